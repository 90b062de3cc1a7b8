/** How the learner came to rest, as every front end tells it, and beside it the truth, which the learner cannot know.
 * @import {Stage, FigureKind, Race} from "../stage.js" */
import {energyText, escaped, fixed} from "../../view/svg.js";
import {card, ending, written} from "./cards.js";

/** @type {FigureKind} */
export const VERDICT = {
  layers: ["learner", "truth"],
  title: "How it ended",
  aspect: 4,
  create: written("lesson-verdict", (stage, layers) => [drawn(stage, layers), "How the learner's run ended, and the truth"]),
};

/** @param {Stage} stage @param {Set<string>} layers */
function drawn(stage, layers) {
  if (!layers.size) return "";
  const race = stage.race((stage.step.race ?? [])[0] ?? "");
  if (!race) return "";
  if (stage.reveal < 1) return '<p class="lesson-waits">The learner is on its way …</p>';
  const names = stage.world.scene.names.map(name => name.split(" ")[0].toLowerCase());
  const {label, says, dot} = ending(race.claim, race, names);
  const told = `<p>${escaped([says, ...reasons(race)].join(" "))}</p>`;
  const learner = layers.has("learner") ? card("learner", "What the learner knows", label, told, dot) : "";
  const isTrueShown = layers.has("truth") && !stage.truthHidden;
  return learner + (isTrueShown ? card("truth", "Only you can see", ...truth(stage, race, names)) : "");
}

/** What the learner found on its way. @param {Race & {leastAsSeen?: number}} race */
function reasons({claim: {unobservable, swapped}, E, leastAsSeen}) {
  const last = E[E.length - 1], small = last < .001 ? "below 0.001 px²" : `${energyText(last)} px²`;
  return [
    ...unobservable.length ? [`E is ${small}, and it does not rise when that joint turns.`] : [],
    ...swapped.length ? [
      `It takes ${pairs(swapped)} to be swapped.`,
      ...leastAsSeen === undefined ? [] : [`As seen, E never fell below ${energyText(leastAsSeen)} px².`],
      `With them changed back, it is ${small}.`,
    ] : [],
  ];
}

/** @param {Stage} stage @param {Race} race @param {string[]} names @returns {[string, string]} */
function truth({moment, records}, {postures}, names) {
  const off = postures[postures.length - 1].map((v, k) => Math.abs(v - moment.thetaDemo[k]) * 180 / Math.PI);
  const most = Math.max(...off), swapped = records.swapped?.length ? `<p>Swapped are ${pairs(records.swapped)}.</p>` : "";
  return [`${fixed(most)}° off, at the ${names[off.indexOf(most)]}.`, swapped];
}

/** @param {number[][]} swapped */
const pairs = swapped => `points ${swapped.map(([i, j]) => `${i} and ${j}`).join(", ")}`;
