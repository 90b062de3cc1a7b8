/**
 * A drawing with a window on something measured in its own unit: px of an image, px of a view from outside, metres of a
 * plan. The window can glide.
 *
 * @typedef {{x: number, y: number, scale: number}} Window what lies at the drawing's corner, and drawing units per unit
 * @typedef {[number, number, number, number]} Box left, top, right, bottom
 */
import {add, drawingSize, px, set} from "../../view/svg.js";

const GLIDE = 0.16; // share of its way that a window goes in a frame
const STILL = 0.3; // drawing units from where a window has arrived

export const isStill = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Plane {
  /** @param {HTMLElement} box @param {string} [kind] class of the drawing */
  constructor(box, kind = "") {
    this.box = box;
    this.svg = add(box, "svg", {class: `vi draw-plane ${kind}`, role: "img"});
    this.ink = add(this.svg, "g");
    /** @type {Window} */
    this.window = {x: 0, y: 0, scale: 0};
    this.width = 1;
    this.height = 1;
    /** px of a drawing's unit */
    this.unit = 1;
    this.last = "";
    this.frame = 0;
    this.measure();
  }

  /** The drawing is as large as its box. Returns whether that has changed. */
  measure() {
    const {unit, width, height} = drawingSize(this.box);
    if (unit === this.unit && width === this.width && height === this.height) return false;
    Object.assign(this, {unit, width, height});
    set(this.svg, {viewBox: `0 0 ${width} ${height}`});
    this.window = {...this.window, scale: 0};
    return true;
  }

  /** Glide to a window that holds a box, centred.
   * @param {Box} box
   * @param {{margin?: Box, most?: number, glide?: boolean}} [options] margin: drawing units that stay free; most:
   * scale @returns {boolean} whether the window has still to move */
  aim([left, top, right, bottom], {margin = [14, 14, 14, 14], most = Infinity, glide = true} = {}) {
    const free = [this.width - margin[0] - margin[2], this.height - margin[1] - margin[3]].map(v => Math.max(v, 20));
    const scale = Math.min(most, free[0] / Math.max(right - left, 1e-9), free[1] / Math.max(bottom - top, 1e-9));
    const goal = {
      x: (left + right) / 2 - (margin[0] + free[0] / 2) / scale,
        y: (top + bottom) / 2 - (margin[1] + free[1] / 2) / scale, scale,
    };
    const {window} = this, share = !window.scale || !glide || isStill() ? 1 : GLIDE;
    for (const name of /** @type {const} */ (["x", "y", "scale"])) window[name] += share * (goal[name] - window[name]);
    const off = (Math.abs(goal.x - window.x) + Math.abs(goal.y - window.y)) * scale
      + 200 * Math.abs(Math.log(scale / window.scale));
    if (off > STILL) return true;
    this.window = goal;
    return false;
  }

  /** Draw again in the next frame, while a window glides. @param {() => void} draw */
  again(draw) {
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => { if (this.box.isConnected) draw(); });
  }

  /** @param {number} a */
  x(a) { return (a - this.window.x) * this.window.scale; }

  /** @param {number} b */
  y(b) { return (b - this.window.y) * this.window.scale; }

  /** @param {ArrayLike<number>} p @returns {[number, number]} */
  at(p) { return [this.x(p[0]), this.y(p[1])]; }

  /** @param {ArrayLike<number>[]} points @param {boolean} [closed] */
  path(points, closed = false) {
    const at = points.map(p => `${px(this.x(p[0]))} ${px(this.y(p[1]))}`).join("L");
    return points.length ? `M${at}${closed ? "z" : ""}` : "";
  }

  /** The whole of a line a x + b y + c = 0 that the drawing shows.
   * @param {{a: number, b: number, c: number}} line @returns {[number, number][]} two places in drawing units */
  ends({a, b, c}) {
    const {x, y, scale} = this.window, k = (c + a * x + b * y) * scale, reach = 2 * (this.width + this.height);
    const mid = [this.width / 2, this.height / 2], off = a * mid[0] + b * mid[1] + k;
    const foot = [mid[0] - a * off, mid[1] - b * off];
    return clipped([foot[0] - b * reach, foot[1] + a * reach], [foot[0] + b * reach, foot[1] - a * reach],
      [0, 0, this.width, this.height]);
  }

  /** px in the box of a place. @param {ArrayLike<number>} place @returns {[number, number]} */
  placed(place) {
    const [x, y] = this.at(place);
    return [x * this.unit, y * this.unit];
  }

  /** The place at px in the box. @param {ArrayLike<number>} at @returns {[number, number]} */
  under(at) {
    const {x, y, scale} = this.window;
    return [at[0] / this.unit / scale + x, at[1] / this.unit / scale + y];
  }

  /** @param {string} html @param {string} label the drawing in words */
  show(html, label) {
    if (html !== this.last) this.ink.innerHTML = this.last = html;
    set(this.svg, {"aria-label": label});
  }
}

/** The part of a segment within a box.
 * @param {number[]} p @param {number[]} q @param {Box} box @returns {[number, number][]} empty for none */
export function clipped(p, q, [left, top, right, bottom]) {
  const d = [q[0] - p[0], q[1] - p[1]];
  let from = 0, to = 1;
  for (const [way, room] of [[-d[0], p[0] - left], [d[0], right - p[0]], [-d[1], p[1] - top], [d[1], bottom - p[1]]]) {
    if (way === 0 ? room < 0 : false) return [];
    if (way < 0) from = Math.max(from, room / way);
    else if (way > 0) to = Math.min(to, room / way);
  }
  if (from >= to) return [];
  return [[p[0] + from * d[0], p[1] + from * d[1]], [p[0] + to * d[0], p[1] + to * d[1]]];
}

/** The box around points. @param {Iterable<ArrayLike<number>>} points @returns {Box} */
export function around(points) {
  /** @type {Box} */
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const p of points) {
    box[0] = Math.min(box[0], p[0]);
    box[1] = Math.min(box[1], p[1]);
    box[2] = Math.max(box[2], p[0]);
    box[3] = Math.max(box[3], p[1]);
  }
  return box;
}

/** @param {number} x @param {number} y @param {number} r */
export const disc = (x, y, r) => `M${px(x - r)} ${px(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`;

/** @param {number} x @param {number} y @param {number} r */
export const diamond = (x, y, r) => `M${px(x - r)} ${px(y)}l${r} ${-r} ${r} ${r} ${-r} ${r}z`;

/** An arrow as a shaft and a tip.
 * @param {ArrayLike<number>} from @param {ArrayLike<number>} to @param {number} [tip] its length
 * @returns {[string, string]} paths, both empty for none */
export function arrow(from, to, tip = 6) {
  const dx = to[0] - from[0], dy = to[1] - from[1], length = Math.hypot(dx, dy);
  if (!(length > .5)) return ["", ""];
  const size = Math.min(tip, length * .7), u = dx / length * size, v = dy / length * size;
  const shaft = `M${px(from[0])} ${px(from[1])}L${px(to[0] - u * .8)} ${px(to[1] - v * .8)}`;
  return [shaft, `M${px(to[0])} ${px(to[1])}L${px(to[0] - u - v * .5)} ` +
    `${px(to[1] - v + u * .5)}L${px(to[0] - u + v * .5)} ${px(to[1] - v - u * .5)}z`];
}
