/** How far the smallest E is from the demonstrator, over the distance of the eyes: a curve for each transfer, both
 * scales logarithmic, with the present distance and what the visitor said.
 * @import {Stage, FigureKind} from "../stage.js"
 * @typedef {{times: number[], degrees: Record<string, number[]>}} Biases */
import {fixed, px} from "../../view/svg.js";
import {stageSmallest} from "../maps.js";
import {short} from "../measured.js";
import {farthest} from "../../engine/engine.js";
import {
  axis, circles, dots, Drawing, legend, legendHeight, path, polyline, sketched, text, widthOf,
} from "./drawing.js";
import {Names} from "./names.js";

const FLOOR = .01, HIGHEST = 30; // degrees; smaller ones are raised to the floor
const ASKED = 10; // times the distance
const DEGREES = [.01, .1, 1, 10], TIMES = [1, 3, 10, 30];
const STYLES = new Map([["epipolar", "used"], ["linear", "second"], ["rank3", "third"], ["projective", "exact"]]);
const HEAD = 8, FOOT = 46, LEFT = 48, BESIDE_FROM = 520; // units; from this width on, names stand beside their curves

/** @type {FigureKind} */
export const BIASES = {
  layers: ["curves", "here", "predicted", "found"],
  title: "From the smallest E to the demonstrator",
  aspect: 1.8,
  create: sketched("lesson-biases", (drawing, stage, layers) => [drawn(drawing, stage, layers), described(stage, layers)]),
};

/** @param {Drawing} drawing @param {Stage} stage @param {Set<string>} layers */
function drawn({width, height}, stage, layers) {
  /** @type {Biases} */
  const {times, degrees} = stage.records.biases, used = stage.session.settings.transfer, isWide = width >= BESIDE_FROM;
  const shown = layers.has("curves") ? [...STYLES.keys()].filter(name => degrees[name]).reverse() : [];
  const nameOf = (/** @type {string} */ name) =>
    `${name.replace("rank3", "rank 3")}${Math.max(...degrees[name]) < FLOOR ? ", < 0.01°" : ""}`;
  /** @type {[string, string, string][]} */
  const rows = shown.toReversed().map(name => [
    path(`lesson-bias lesson-bias-${STYLES.get(name)}`, "M0 0h30"), nameOf(name),
    `vi-b lesson-bias-words-${STYLES.get(name)}`,
  ]);
  const foot = FOOT + (isWide ? 0 : legendHeight(rows, width));
  const widest = Math.max(...[...STYLES.keys()].filter(name => degrees[name]).map(name => widthOf(nameOf(name), true)));
  const right = width - (isWide ? widest + 14 : 12);
  const bottom = height - foot, x = axis(1, 30, LEFT, right, true), y = axis(FLOOR, HIGHEST, bottom, HEAD, true);
  const at = (/** @type {number} */ v, /** @type {number} */ value) =>
    [x(v), y(Math.min(Math.max(value, FLOOR), HIGHEST))];
  const names = new Names([LEFT, HEAD, right, bottom]);
  let svg = path("vi-rule", DEGREES.map(v => `M${LEFT} ${px(y(v))}H${px(right)}`).join(""));
  const ticks = TIMES.map(v => `M${px(x(v))} ${px(bottom)}v4`).join("");
  svg += path("vi-axis", `M${LEFT} ${HEAD}V${px(bottom)}H${px(right)}${ticks}`);
  svg += DEGREES.map(v => text(LEFT - 6, y(v) + 4.5, `${v}°`, "vi-2nd vi-end")).join("");
  svg += TIMES.map(v => text(x(v), bottom + 17, `${v} ×`, "vi-2nd vi-mid")).join("");
  svg += text((LEFT + right) / 2, bottom + 34, "distance of the eyes", "vi-2nd vi-mid");
  for (const name of shown) {
    const points = degrees[name].map((value, k) => at(times[k], value));
    names.keepLine(points, 4);
    svg += path(`lesson-bias lesson-bias-${STYLES.get(name)}`, polyline(points));
  }
  const end = (/** @type {string} */ name) => y(Math.max(degrees[name][times.length - 1], FLOOR));
  const ends = shown.map(name => ({name, at: end(name), words: nameOf(name)}));
  svg += isWide ? besideCurves(ends, right) : legend(rows, 4, height - legendHeight(rows, width) + 6, width).drawn;
  const here = stage.sliders.get("distance") ?? 1, now = biasNow(stage);
  if (layers.has("here")) {
    svg += path("lesson-here", `M${px(x(here))} ${HEAD}V${px(bottom)}`);
    if (now !== null) svg += path("lesson-bias-dots lesson-bias-used", dots([at(here, now)]));
    names.keepLine([[x(here), HEAD], [x(here), bottom]], 2);
    if (now !== null) names.keep(at(here, now), 6);
    names.put("here", [x(here), HEAD + 14], "", {first: [1, 0]});
  }
  const found = valueAt(ASKED, times, degrees[used]), goal = at(ASKED, found), guess = stage.answer.number;
  if (layers.has("found")) names.keep(goal, 9);
  const you = guess !== undefined && layers.has("predicted") ? at(ASKED, guess) : null;
  if (you) names.keep(you, 16);
  if (layers.has("found") && you) svg += path("lesson-gap", polyline([you, goal]));
  if (layers.has("found")) {
    svg += path("lesson-ring", circles([goal], 6.5));
    names.put(`${short(found)}°`, goal, "", {away: 13});
  }
  if (you) {
    svg += crossHair(you);
    names.put(`you: ${short(Number(guess))}°`, you, "", {away: 19});
  }
  return svg + names.html;
}

/** Names at the ends of curves, which do not overlap.
 * @param {{name: string, at: number, words: string}[]} ends @param {number} right */
function besideCurves(ends, right) {
  let above = Infinity;
  return ends.sort((a, b) => b.at - a.at).map(({name, at, words}) => {
    above = Math.min(at + 4.5, above - 16);
    return text(right + 7, above, words, `vi-b lesson-bias-words-${STYLES.get(name)}`);
  }).join("");
}

/** Between distances, by their logarithm. @param {number} at @param {number[]} times @param {number[]} values */
function valueAt(at, times, values) {
  const k = Math.max(1, times.findIndex(v => v >= at));
  const share = Math.log(at / times[k - 1]) / Math.log(times[k] / times[k - 1]);
  return values[k - 1] + share * (values[k] - values[k - 1]);
}

/** Degrees from the smallest E to the demonstrator as the eyes stand. @param {Stage} stage */
function biasNow(stage) {
  const lowest = stageSmallest(stage);
  return lowest && farthest(lowest, stage.moment.thetaDemo);
}

/** @param {Stage} stage @param {Set<string>} layers */
function described(stage, layers) {
  /** @type {Biases} */
  const {times, degrees} = stage.records.biases, used = stage.session.settings.transfer, here = biasNow(stage);
  const words = ["How far the smallest E is from the demonstrator, over the distance of the eyes"];
  if (here !== null) words.push(`at ${fixed(stage.sliders.get("distance") ?? 1)} times the distance ${short(here)}°`);
  if (layers.has("found")) words.push(`at ${ASKED} times ${short(valueAt(ASKED, times, degrees[used]))}°`);
  if (stage.answer.number !== undefined) words.push(`you said ${short(stage.answer.number)}°`);
  return `${words.join("; ")}.`;
}

/** The visitor's own mark: a cross hair. @param {number[]} at */
function crossHair([x, y]) {
  const hair = circles([[x, y]], 9.5) + [[1, 0], [-1, 0], [0, 1], [0, -1]].map(([u, v]) =>
    `M${px(x + 7 * u)} ${px(y + 7 * v)}l${8 * u} ${8 * v}`).join("");
  return path("lesson-you-case", hair) + path("lesson-you", hair);
}
