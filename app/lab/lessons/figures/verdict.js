/**
 * What the learner says of itself when it has come to rest, and beside it the truth, which it cannot know.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").FigureKind} FigureKind
 * @typedef {Object} Claim of a run, as the library records it
 * @property {string} status
 * @property {number[]} unobservable joints that the learner knows nothing of
 * @property {number[][]} swapped pairs of points that the learner takes to bear each other's names
 */
import {energyText, fixed} from "../../view/svg.js";
import {card, written} from "./cards.js";
import {escaped} from "./drawing.js";

const ENDINGS = new Map([
  ["converged", "I have arrived."],
  ["settled", "I rest where E is smallest, and do not know whether I have arrived."],
  ["no-progress", "I have found no smaller E, and have not arrived."],
  ["too-few-points", "I see too few points."],
]);
/** @type {FigureKind} */
export const VERDICT = {
  layers: ["learner", "truth"],
  title: "What the learner says",
  aspect: 4,
  create: written("lesson-verdict", "The learner's words about itself, and the truth", drawn),
};

/** @param {Stage} stage @param {Set<string>} layers */
function drawn(stage, layers) {
  if (!layers.size) return "";
  const race = stage.race((stage.step.race ?? [])[0] ?? "");
  if (!race?.claim) return "";
  if (stage.reveal < 1) return '<p class="lesson-waits">The learner is on its way …</p>';
  /** @type {Claim} */
  const claim = race.claim, names = stage.world.scene.names.map(name => name.split(" ")[0].toLowerCase());
  const learner = layers.has("learner") ? spoken("learner", "The learner says", says(claim, race, names)) : "";
  const isTrueShown = layers.has("truth") && !stage.truthHidden;
  return learner + (isTrueShown ? spoken("truth", "Only you can see", truth(stage, race, names)) : "");
}

/** @param {"learner" | "truth"} kind @param {string} head @param {string[]} words sentences, the first one bold */
const spoken = (kind, head, [first, ...rest]) =>
  card(kind, head, first, rest.length ? `<p>${escaped(rest.join(" "))}</p>` : "");

/** @param {Claim} claim @param {import("../stage.js").Race & {leastAsSeen?: number}} race @param {string[]} names */
function says({status, unobservable, swapped}, {E, leastAsSeen}, names) {
  const motions = E.length - 1, last = E[motions], small = last < .001 ? "below 0.001 px²" : `${energyText(last)} px²`;
  const ending = ENDINGS.get(status) ?? `I have stopped after ${motions} steps.`;
  if (swapped.length) return [
    `Something does not fit: ${pairs(swapped)} seem to be swapped.`,
    leastAsSeen === undefined ? "" : `As I saw them, E never fell below ${energyText(leastAsSeen)} px².`,
    `With them changed back, it is ${small}.`, ending,
  ];
  if (unobservable.length) return [
    `I cannot know the ${unobservable.map(k => names[k]).join(" and the ")}.`,
    `E is ${small} after ${motions} steps, and it does not rise when that joint turns.`,
    "I do not claim to have arrived.",
  ];
  return [ending, `E is ${small} after ${motions} steps.`];
}

/** @param {Stage} stage @param {import("../stage.js").Race} race @param {string[]} names */
function truth({moment, records}, {postures}, names) {
  const off = postures[postures.length - 1].map((v, k) => Math.abs(v - moment.thetaDemo[k]) * 180 / Math.PI);
  const words = [`${fixed(Math.max(...off))}° off, at the ${names[off.indexOf(Math.max(...off))]}.`];
  return records.swapped?.length ? [...words, `Swapped are ${pairs(records.swapped)}.`] : words;
}

/** @param {number[][]} swapped */
const pairs = swapped => `points ${swapped.map(([i, j]) => `${i} and ${j}`).join(", ")}`;
