/**
 * What an image shows, layer by layer. A layer is a function that returns SVG; those of a step's figures are drawn in the
 * order of this table.
 * @import {Stage} from "../stage.js" @import {Outline} from "../../view/images.js"
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
 * @property {(line: {a: number, b: number, c: number}) => [number, number][]} ends where it enters and leaves, left first
 * @property {Set<string>} layers
 * @property {import("../../view/images.js").Outlines} outlines
 * @typedef {(frame: Frame, stage: Stage) => string} Layer */
import {clamp} from "../../engine/engine.js";
import {px} from "../../view/svg.js";
import {drawnEllipse, ellipseOf} from "./crossing.js";
import {arrows, circles, diamonds, dots, path, polyline, text} from "./drawing.js";

/** A line through the whole drawing, with its name along it.
 * @param {Frame} frame @param {{a: number, b: number, c: number} | null} line @param {string} kind
 * @param {string} [name] @param {number} [share] of its way, where the name stands */
export function lineThrough(frame, line, kind, name = "", share = .8) {
  const ends = line ? frame.ends(line) : [];
  if (!ends.length) return "";
  const [[a, b], [c, d]] = ends, turn = Math.atan2(d - b, c - a) * 180 / Math.PI, whole = polyline(ends);
  const words = name && `<g transform="translate(${px(a + share * (c - a))} ${px(b + share * (d - b))})rotate(${px(turn)})">${
    text(0, -6, name, "vi-chosen vi-halo vi-mid")}</g>`;
  return path("vi-line-case", whole) + path(kind, whole) + words;
}

/** @param {Outline} outline @param {Frame} frame @param {string} hull @param {string} bone */
export function arm(outline, {at}, hull, bone) {
  const closed = outline.hulls.map(points => `${polyline(points.map(at))}z`).join("");
  return path(hull, closed) + path(bone, polyline(outline.bones.map(at)));
}

/** From each recovered point to the own one.
 * @param {Frame} frame @param {Stage} stage @returns {[number, number][][]} */
export function residuals({of}, stage) {
  const {usable, views: {own}} = stage.moment, found = stage.recovered();
  return usable.map(i => [of(found, i), of(own, i)]);
}

/** @param {number[][]} points @param {number} r @param {string} kind */
export const rings = (points, r, kind) => path(kind, circles(points, r));

/** Outlines of the learner in another posture.
 * @param {Frame} frame @param {Stage} stage @param {number[]} theta @param {string} name */
const elsewhere = ({outlines, side}, {world}, theta, name) => outlines.of(world, "learner", theta, name)[side];

/** Its points there. @param {Frame} frame @param {Stage} stage @param {number[]} theta */
export const pointsIn = ({of, shown}, {world}, theta) => {
  const {images} = world.look("learner", theta);
  return shown.map(i => of(images, i));
};

/** A layer of L and R alone. @param {Layer} layer @returns {Layer} */
export const ofOwn = layer => (frame, stage) => frame.isDemo ? "" : layer(frame, stage);

/** @type {Record<string, Layer>} */
export const OWN_LAYERS = {
  "framed": () => "",
  "guessed": ofOwn((frame, stage) =>
    arm(elsewhere(frame, stage, stage.guessed, "guess"), frame, "vi-guess", "vi-guess-bone")),
  "guessed arrows": ofOwn((frame, stage) => {
    const there = pointsIn(frame, stage, stage.guessed), goal = pointsIn(frame, stage, stage.moment.thetaDemo);
    return rings(goal, 4.4, "vi-goal-ring") + arrows(there.map((p, k) => [p, goal[k]]));
  }),
  "skeleton": (frame, stage) => {
    const {moment, world} = stage, {fitted} = moment;
    if (frame.isDemo || !fitted) return "";
    const [left, right] = frame.outlines.of(world, "demonstrator", moment.thetaDemo, "demo");
    const found = fitted.recover(Float64Array.from(left.bones.flatMap((p, i) =>
      [p[0], p[1], right.bones[i][0], right.bones[i][1]])));
    return path("vi-bone vi-found", polyline(left.bones.map((_, i) => frame.of(found, i))));
  },
  "points": frame =>
    frame.isDemo ? path("vi-seen", diamonds(frame.shown.map(i => frame.of(frame.images, i)), 4.6)) : "",
  "arrows": ofOwn((frame, stage) => arrows(residuals(frame, stage))),
  "own points": ofOwn((frame, stage) =>
    path("vi-own vi-own-large", dots(residuals(frame, stage).map(([, own]) => own)))),
  "recovered points": ofOwn((frame, stage) =>
    path("vi-found", diamonds(residuals(frame, stage).map(([found]) => found), 5))),
  "own chosen": ({isDemo, of, images, shown}, {chosen}) => !isDemo && shown.includes(chosen)
    ? path("vi-own vi-own-large", dots([of(images, chosen)])) + rings([of(images, chosen)], 11, "vi-ring") : "",
};

const RING = 10, NAME = 19, EDGE = 12; // units: of a ring, from a point to its name, from there to the drawing's edge

/** @type {Record<string, Layer>} */
export const LIMITS_LAYERS = {
  "pair": (frame, stage) => {
    /** @type {number[][]} */
    const pairs = stage.records.swapped ?? [];
    return pairs.filter(pair => pair.every(i => frame.shown.includes(i))).map(pair => {
      const [from, to] = pair.map(i => frame.of(frame.images, i)), long = Math.hypot(to[0] - from[0], to[1] - from[1]);
      const unit = [0, 1].map(k => (to[k] - from[k]) / Math.max(long, 1e-9));
      const near = from.map((v, k) => v + RING * unit[k]), far = to.map((v, k) => v - RING * unit[k]);
      const joined = long > 2 * RING ? polyline([near, far]) : "", names = frame.isDemo ? [...pair].reverse() : pair;
      const drawn = path("lesson-pair-case", joined) + path("lesson-pair", joined);
      return drawn + path("lesson-pair-ring", circles([from, to], RING))
        + named(frame, from, unit, -NAME, names[0]) + named(frame, to, unit, NAME, names[1]);
    }).join("");
  },
  "ellipse": (frame, stage) => {
    const found = frame.isDemo ? null : ellipseOf(stage, frame.side);
    return found ? drawnEllipse(frame.at(found.at), found.halfAxes.map(v => v * frame.scale), found.direction) : "";
  },
};

/** A point's name beyond a ring, within the drawing.
 * @param {Frame} frame @param {number[]} at @param {number[]} unit along the pair @param {number} by units
 * @param {number} name */
function named({width, height}, at, unit, by, name) {
  const x = clamp(at[0] + by * unit[0], EDGE, width - EDGE), y = clamp(at[1] + by * unit[1], EDGE, height - EDGE);
  return text(x, y + 4.5, String(name), "lesson-pair-name vi-b vi-halo vi-mid");
}

export const mark = (/** @type {string} */ inside, /** @type {number} */ wide = 8) =>
  `<svg viewBox="${-wide} -8 ${2 * wide} 16" class="vi" aria-hidden="true">${inside}</svg>`;
export const arrow = (/** @type {string} */ kind, /** @type {string} */ tip) =>
  mark(`<path class="${kind}" d="M-11 0h15"/><path class="${tip}" d="M11 0l-7-3.5v7z"/>`, 13);

/** What marks mean, by layer: HTML. @type {Record<string, string>} */
export const OWN_LEGEND = {
  "points": `${mark('<path class="vi-seen" d="M-5 0l5-5 5 5-5 5z"/>')}point of the demonstrator`,
  "own points": `${mark('<path class="vi-own" d="M0 0h0"/>')}own point`,
  "recovered points": `${mark('<path class="vi-found" d="M-5 0l5-5 5 5-5 5z"/>')}where the lines put it`,
  "arrows": `${arrow("vi-e", "vi-tip")}arrow: the disagreement`,
  "skeleton": `${mark('<path class="vi-bone vi-found" d="M-12 3l12-6 12 6"/>', 13)}arm by the lines`,
  "ghost": `${mark('<rect class="vi-goal" x="-7" y="-6" width="14" height="12" rx="4"/><circle class="vi-goal-ring" r="3.4"/>')}ghost: the learner in the demonstrator’s pose`,
  "guessed": `${mark('<rect class="vi-guess" x="-7" y="-6" width="14" height="12" rx="4"/>')}your guess`,
};
