/** A drawing with a window on something measured in its own unit: px of an image, px of a view from outside, metres of
 * a plan. The window can glide.
 * @typedef {{x: number, y: number, scale: number}} Window what lies at the drawing's corner, and drawing units per
 * unit @import {Rectangle} from "./drawing.js" */
import {clipped, Drawing, polyline} from "./drawing.js";

const GLIDE = 0.16; // share of its way that a window goes in a frame
const STILL = 0.3; // drawing units from where a window has arrived

export const isStill = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Plane extends Drawing {
  frame = 0;
  window = {x: 0, y: 0, scale: 0};

  /** @param {HTMLElement} box @param {string} [kind] class of the drawing */
  constructor(box, kind = "") { super(box, kind, false); }

  measure() {
    const {unit, width, height} = this;
    super.measure();
    if (unit !== this.unit || width !== this.width || height !== this.height) this.window = {x: 0, y: 0, scale: 0};
  }

  /** Glide to a window that holds a box, centred.
   * @param {Rectangle} box
   * @param {{margin?: Rectangle, most?: number, glide?: boolean}} [options] margin: drawing units that stay free; most:
   * scale @returns {boolean} whether the window has still to move */
  aim([left, top, right, bottom], {margin = [14, 14, 14, 14], most = Infinity, glide = true} = {}) {
    const free = [this.width - margin[0] - margin[2], this.height - margin[1] - margin[3]].map(v => Math.max(v, 20));
    const scale = Math.min(most, free[0] / Math.max(right - left, 1e-9), free[1] / Math.max(bottom - top, 1e-9));
    const goal = {scale, x: (left + right) / 2 - (margin[0] + free[0] / 2) / scale,
      y: (top + bottom) / 2 - (margin[1] + free[1] / 2) / scale};
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

  /** @param {ArrayLike<number>} p @returns {[number, number]} */
  at(p) {
    const {x, y, scale} = this.window;
    return [(p[0] - x) * scale, (p[1] - y) * scale];
  }

  /** @param {ArrayLike<number>[]} points @param {boolean} [closed] */
  path(points, closed = false) {
    return points.length ? polyline(points.map(p => this.at(p))) + (closed ? "z" : "") : "";
  }

  /** The whole of a line a x + b y + c = 0 that the drawing shows, left first; empty if it misses it.
   * @param {{a: number, b: number, c: number}} line @returns {[number, number][]} two places in drawing units */
  ends({a, b, c}) {
    const {x, y, scale} = this.window, k = (c + a * x + b * y) * scale, reach = 2 * (this.width + this.height);
    const mid = [this.width / 2, this.height / 2], off = a * mid[0] + b * mid[1] + k;
    const foot = [mid[0] - a * off, mid[1] - b * off];
    return clipped([foot[0] - b * reach, foot[1] + a * reach], [foot[0] + b * reach, foot[1] - a * reach],
      [0, 0, this.width, this.height]).sort((p, q) => p[0] - q[0]);
  }

  resize() { this.measure(); }

  /** px in the box of a place. @param {unknown} _ @param {ArrayLike<number>} place @returns {[number, number]} */
  place(_, place) {
    const [x, y] = this.at(place);
    return [x * this.unit, y * this.unit];
  }

  /** The place at px in the box. @param {unknown} _ @param {ArrayLike<number>} at @returns {[number, number]} */
  unplace(_, at) {
    const {x, y, scale} = this.window;
    return [at[0] / this.unit / scale + x, at[1] / this.unit / scale + y];
  }
}
