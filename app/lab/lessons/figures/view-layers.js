/**
 * What an image shows, layer by layer. A layer is a function that returns SVG; those of a step's figures are drawn in the
 * order of this table.
 *
 * @import {Stage} from "../stage.js"
 * @typedef {Object} Frame one image as it is drawn
 * @property {"l" | "r" | "L" | "R"} name
 * @property {number} k 0 … 3, of l, r, L, R
 * @property {0 | 1} side left or right
 * @property {boolean} isDemo whether it shows the demonstrator
 * @property {Float64Array} images (4 N) px, of what it shows
 * @property {Uint8Array} seen (2 N)
 * @property {number} width of the drawing
 * @property {number} height
 * @property {number} scale drawing units of a px
 * @property {(p: ArrayLike<number>) => [number, number]} at px of the image → drawing units
 * @property {(of: ArrayLike<number>, point: number) => [number, number]} of an image point, in drawing units
 * @property {number[]} shown the points that this image shows
 * @property {Set<string>} layers
 * @property {import("../../view/images.js").Outlines} outlines
 * @typedef {(frame: Frame, stage: Stage) => string} Layer
 */
import {px} from "../../view/svg.js";

const HEAD = 7.5; // drawing units of an arrow's tip

/** @param {number[][]} points in drawing units @param {string} kind */
export const dots = (points, kind) =>
  `<path class="${kind}" d="${points.map(([x, y]) => `M${px(x)} ${px(y)}h0`).join("")}"/>`;

/** @param {number[][]} points @param {number} r half a diagonal @param {string} kind */
export const diamonds = (points, r, kind) =>
  `<path class="${kind}" d="${points.map(([x, y]) => `M${px(x - r)} ${px(y)}l${r} ${-r} ${r} ${r} ${-r} ${r}z`).join("")}"/>`;

/** @param {number[][]} points @param {number} r @param {string} kind */
export const rings = (points, r, kind) => points.map(([x, y]) =>
  `<circle class="${kind}" cx="${px(x)}" cy="${px(y)}" r="${r}"/>`).join("");

/** @param {number[][]} points @param {string} kind */
export const polyline = (points, kind) =>
  `<path class="${kind}" d="M${points.map(([x, y]) => `${px(x)} ${px(y)}`).join("L")}"/>`;

/** Arrows with tips. @param {number[][][]} ends @param {string} kind @param {string} tip its class */
export function arrows(ends, kind, tip) {
  let shafts = "", tips = "";
  for (const [[a, b], [c, d]] of ends) {
    const length = Math.hypot(c - a, d - b), head = Math.min(HEAD, length * .6), u = (c - a) / length * head,
      v = (d - b) / length * head;
    shafts += `M${px(a)} ${px(b)}L${px(c - (length > HEAD ? u * .7 : 0))} ${px(d - (length > HEAD ? v * .7 : 0))}`;
    if (length > 3) tips += `M${px(c)} ${px(d)}L${px(c - u - v / 2)} ${px(d - v + u / 2)}L${px(c - u + v / 2)} ${px(d - v - u / 2)}z`;
  }
  return `<path class="${kind}" d="${shafts}"/><path class="${tip}" d="${tips}"/>`;
}

/** @param {number} x @param {number} y @param {string} words @param {string} kind */
export const words = (x, y, words, kind) => `<text class="${kind}" x="${px(x)}" y="${px(y)}">${words}</text>`;

/** Where a line of the image enters and leaves the drawing, left first; null if it misses it.
 * @param {Frame} frame @param {{a: number, b: number, c: number}} line @returns {[number[], number[]] | null} */
export function chord({at, scale, width, height}, {a, b, c}) {
  const size = Math.hypot(a, b), [n, m] = [a / size, b / size], [x0, y0] = at([0, 0]),
    off = c / size * scale - n * x0 - m * y0;
  const ends = [];
  if (Math.abs(m) > 1e-9) for (const x of [0, width]) ends.push([x, -(off + n * x) / m]);
  if (Math.abs(n) > 1e-9) for (const y of [0, height]) ends.push([-(off + m * y) / n, y]);
  const inside = ends.filter(([x, y]) => x > -1e-6 && x < width + 1e-6 && y > -1e-6 && y < height
    + 1e-6).sort((p, q) => p[0] - q[0]);
  return inside.length < 2 ? null : [inside[0], inside[inside.length - 1]];
}

/** A line through the whole drawing, with its name along it.
 * @param {Frame} frame @param {{a: number, b: number, c: number} | null} line @param {string} kind
 * @param {string} [name] @param {number} [share] of its way, where the name stands */
export function lineThrough(frame, line, kind, name = "", share = .8) {
  const ends = line && chord(frame, line);
  if (!ends) return "";
  const [[a, b], [c, d]] = ends, x = a + share * (c - a), y = b + share * (d - b),
    turn = Math.atan2(d - b, c - a) * 180 / Math.PI;
  const path = `M${px(a)} ${px(b)}L${px(c)} ${px(d)}`;
  const named = name
    && `<g transform="translate(${px(x)} ${px(y)})rotate(${px(turn)})">${words(0, -6, name, "vi-chosen vi-halo vi-mid")}</g>`;
  return `<path class="vi-line-case" d="${path}"/><path class="${kind}" d="${path}"/>${named}`;
}

/** @param {import("../../view/images.js").Outline} outline @param {Frame} frame @param {string} hull
 * @param {string} bone */
export function arm(outline, {at}, hull, bone) {
  const closed = outline.hulls.map(points => `M${points.map(p => at(p).map(px).join(" ")).join("L")}z`).join("");
  return `<path class="${hull}" d="${closed}"/>${polyline(outline.bones.map(at), bone)}`;
}

/** @param {Frame} frame @param {Stage} stage @returns {[number, number][]} recovered points, then own ones */
function pairs({side, at}, {moment}, found = new Float64Array(0)) {
  return /** @type {[number, number][]} */ (/** @type {unknown} */ (moment.usable.map(i =>
    [at([found[4 * i + 2 * side], found[4 * i + 2 * side + 1]]),
    at([moment.views.own[4 * i + 2 * side], moment.views.own[4 * i + 2 * side + 1]])])));
}

/** @param {Frame} frame @param {Stage} stage @returns {[number, number][][]} from each recovered point to the own one
 */
export const residuals = (frame, stage) => /** @type {any} */ (pairs(frame, stage, stage.recovered()));

/** Outlines of the learner in another posture.
 * @param {Frame} frame @param {Stage} stage @param {number[]} theta @param {string} name */
const elsewhere = ({outlines, side}, {world}, theta, name) => outlines.of(world, "learner", theta, name)[side];

/** Its points there. @param {Frame} frame @param {Stage} stage @param {number[]} theta */
const pointsIn = ({of, shown}, {world}, theta) => {
  const {images} = world.look("learner", theta);
  return shown.map(i => of(images, i));
};

/** @type {Record<string, Layer>} */
export const OWN_LAYERS = {
  "framed": () => "",
  "guessed": (frame, stage) => frame.isDemo ? "" : arm(elsewhere(frame, stage, stage.guessed, "guess"), frame,
    "vi-guess", "vi-guess-bone"),
  "guessed arrows": (frame, stage) => {
    if (frame.isDemo) return "";
    const there = pointsIn(frame, stage, stage.guessed), goal = pointsIn(frame, stage, stage.moment.thetaDemo);
    return rings(goal, 4.4, "vi-goal-ring") + arrows(there.map((p, k) => [p, goal[k]]), "vi-e", "vi-tip");
  },
  "skeleton": (frame, stage) => {
    const {moment, world} = stage, {fitted} = moment;
    if (frame.isDemo || !fitted) return "";
    const [left, right] = frame.outlines.of(world, "demonstrator", moment.thetaDemo, "demo");
    const found = fitted.recover(Float64Array.from(left.bones.flatMap((p, i) =>
      [p[0], p[1], right.bones[i][0], right.bones[i][1]])));
    return polyline(left.bones.map((_, i) => frame.of(found, i)), "vi-bone vi-found");
  },
  "points": frame => frame.isDemo ? diamonds(frame.shown.map(i => frame.of(frame.images, i)), 4.6, "vi-seen") : "",
  "arrows": (frame, stage) => frame.isDemo ? "" : arrows(residuals(frame, stage), "vi-e", "vi-tip"),
  "own points": (frame, stage) => frame.isDemo ? "" : dots(residuals(frame, stage).map(([, own]) => own),
    "vi-own vi-own-large"),
  "recovered points": (frame, stage) => frame.isDemo ? ""
    : diamonds(residuals(frame, stage).map(([found]) => found), 5, "vi-found"),
  "own chosen": ({isDemo, of, images, shown}, {chosen}) => !isDemo && shown.includes(chosen)
    ? dots([of(images, chosen)], "vi-own vi-own-large") + rings([of(images, chosen)], 11, "vi-ring") : "",
  "arrow": (frame, stage) => {
    const k = stage.moment.usable.indexOf(stage.chosen);
    return frame.isDemo || k < 0 ? "" : arrows([residuals(frame, stage)[k]], "vi-e", "vi-tip");
  },
};

const mark = (/** @type {string} */ inside, /** @type {number} */ wide = 8) =>
  `<svg viewBox="${-wide} -8 ${2 * wide} 16" class="vi" aria-hidden="true">${inside}</svg>`;
const arrow = (/** @type {string} */ kind) =>
  mark(`<path class="${kind}" d="M-11 0h15"/><path class="${kind === "vi-e" ? "vi-tip" : "vi-way-tip"}" d="M11 0l-7-3.5v7z"/>`, 13);

/** What marks mean, by layer: HTML. @type {Record<string, string>} */
export const OWN_LEGEND = {
  "points": `${mark('<path class="vi-seen" d="M-5 0l5-5 5 5-5 5z"/>')}point of the demonstrator`,
  "own points": `${mark('<path class="vi-own" d="M0 0h0"/>')}own point`,
  "recovered points": `${mark('<path class="vi-found" d="M-5 0l5-5 5 5-5 5z"/>')}where the lines put it`,
  "arrows": `${arrow("vi-e")}arrow: the disagreement`,
  "skeleton": `${mark('<path class="vi-bone vi-found" d="M-12 3l12-6 12 6"/>', 13)}arm by the lines`,
  "ghost": `${mark('<rect class="vi-goal" x="-7" y="-6" width="14" height="12" rx="4"/><circle class="vi-goal-ring" r="3.4"/>')}ghost: the learner in the demonstrator’s pose`,
  "guessed": `${mark('<rect class="vi-guess" x="-7" y="-6" width="14" height="12" rx="4"/>')}your guess`,
};
