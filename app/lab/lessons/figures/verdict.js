/**
 * What the learner says of itself when it has come to rest, and beside it the truth, which it cannot know.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").FigureKind} FigureKind
 * @typedef {Object} Claim of a run, as the library records it
 * @property {string} status
 * @property {number[]} offDeg of each joint: the truth
 * @property {number[]} unobservable joints that the learner knows nothing of
 * @property {number[][]} swapped pairs of points that the learner takes to bear each other's names
 */
import {energyText, fixed} from "../../view/svg.js";
import {escaped} from "./drawing.js";

const ENDINGS = new Map([
  ["converged", "I have arrived."],
  ["settled", "I rest where E is smallest, and do not know whether I have arrived."],
  ["no-progress", "I have found no smaller E, and have not arrived."],
  ["too-few-points", "I see too few points."],
]);
const ICONS = {learner: '<circle cx="8" cy="8" r="6"/>', truth: '<path d="M8 1l7 7-7 7-7-7z"/>'};
const HEADS = {learner: "The learner says", truth: "Only you can see"};

/** @type {FigureKind} */
export const VERDICT = {
  layers: ["learner", "truth"],
  title: "What the learner says",
  aspect: 4,
  create(box) {
    box.classList.add("lesson-verdict");
    let last = "";
    return {
      draw(stage, layers) {
        const html = drawn(stage, layers);
        if (html !== last) box.innerHTML = last = html;
      },
    };
  },
};

/** @param {Stage} stage @param {Set<string>} layers */
function drawn(stage, layers) {
  if (!layers.size) return "";
  const race = stage.race((stage.step.race ?? [])[0] ?? "");
  if (!race?.claim) return "";
  if (stage.reveal < 1) return '<p class="lesson-waits">The learner is on its way …</p>';
  /** @type {Claim} */
  const claim = race.claim, names = stage.world.scene.names.map(name => name.split(" ")[0].toLowerCase());
  const boxes = [];
  if (layers.has("learner")) boxes.push(card("learner", says(claim, race, names)));
  if (layers.has("truth") && !stage.truthHidden) boxes.push(card("truth", truth(claim, names, stage.records.swapped ?? [])));
  return boxes.join("");
}

/** @param {Claim} claim @param {import("../stage.js").Race & {leastAsSeen?: number}} race @param {string[]} names */
function says({status, unobservable, swapped}, {E, leastAsSeen}, names) {
  const motions = E.length - 1, last = E[motions], small = last < .001 ? "below 0.001 px²" : `${energyText(last)} px²`;
  const ending = ENDINGS.get(status) ?? `I have stopped after ${motions} motions.`;
  if (swapped.length) {
    const before = leastAsSeen === undefined ? "" : `As I saw them, E never fell below ${energyText(leastAsSeen)} px². `;
    return [`Something does not fit: ${pairs(swapped)} seem to be swapped.`, `${before}With them changed back, it is ${small}.`, ending];
  }
  if (unobservable.length) return [`I cannot know the ${unobservable.map(k => names[k]).join(" and the ")}.`,
    `E is ${small} after ${motions} motions, and it does not rise when that joint turns.`, "I do not claim to have arrived."];
  return [ending, `E is ${small} after ${motions} motions.`];
}

/** @param {Claim} claim @param {string[]} names @param {number[][]} swapped */
function truth({offDeg}, names, swapped) {
  const k = offDeg.indexOf(Math.max(...offDeg)), words = [`${fixed(offDeg[k])}° off, at the ${names[k]}.`];
  return swapped.length ? [...words, `Swapped are ${pairs(swapped)}.`] : words;
}

/** @param {number[][]} swapped */
const pairs = swapped => `points ${swapped.map(([i, j]) => `${i} and ${j}`).join(", ")}`;

/** @param {"learner" | "truth"} kind @param {string[]} words sentences, the first of them in bold */
const card = (kind, [first, ...rest]) => `<div class="lesson-says lesson-says-${kind}"><small><svg viewBox="0 0 16 16" aria-hidden="true">${
  ICONS[kind]}</svg>${HEADS[kind]}</small><b>${escaped(first)}</b>${rest.length ? `<p>${escaped(rest.join(" "))}</p>` : ""}</div>`;
