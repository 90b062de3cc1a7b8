/** Names in a drawing that cover neither each other nor what has to be seen.
 * @typedef {Rectangle} Box in drawing units @import {Rectangle} from "./drawing.js" */
import {escaped, px} from "../../view/svg.js";
import {clipped, widthOf} from "./drawing.js";

const SIDES = [[1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]]; // of a place, for its name
const MAX_RINGS = 8, RING = 14; // how far a name goes from its place, drawing units
const LED = 14; // from a place's mark at which a name has a line to it
const EDGE = 3; // between a name and its bounds

export class Names {
  /** @type {Box[]} */
  taken = [];
  html = "";

  /** @param {Box} bounds within which names stay */
  constructor(bounds) { this.bounds = bounds; }

  /** Keep a place free. @param {ArrayLike<number>} p drawing units @param {number} radius */
  keep(p, radius) {
    if (Number.isFinite(p[0] + p[1])) this.keepBox([p[0] - radius, p[1] - radius, p[0] + radius, p[1] + radius]);
  }

  /** Keep a line free. @param {number[][]} points of a polyline @param {number} [radius] on both sides */
  keepLine(points, radius = 3) {
    points.slice(1).forEach((q, k) => {
      const part = clipped(points[k], q, this.bounds);
      if (!part.length) return;
      const [[a, b], [c, d]] = part, count = Math.ceil(Math.hypot(c - a, d - b) / 6) || 1;
      for (let i = 0; i <= count; i++) this.keep([a + (c - a) * i / count, b + (d - b) * i / count], radius);
    });
  }

  /** @param {Box} box */
  keepBox(box) { this.taken.push(box); }

  /** Whether a box is within the bounds and covers nothing that is kept free. @param {Box} box */
  isFree(box) {
    const [left, top, right, bottom] = this.bounds;
    return box[0] >= left && box[1] >= top && box[2] <= right && box[3] <= bottom && !this.#covered(box);
  }

  /** A name near a place, where most room is left, with a line to it where it is far.
   * @param {string} words @param {ArrayLike<number>} at drawing units @param {string} kind classes of the text
   * @param {{size?: number, away?: number, clear?: number, first?: number[], lead?: string}} [options] away: from
   * the place; clear: radius of its mark; first: side that is tried first; lead: class of the line */
  put(words, at, kind, {size = 13, away = 12, clear = away, first, lead = "vi-lead"} = {}) {
    const wide = widthOf(words, true, size) + 2, high = size * 1.15, {bounds} = this;
    const sides = first ? [first, ...SIDES] : SIDES;
    let best = /** @type {Box | null} */ (null), least = Infinity;
    for (let ring = 0; ring < MAX_RINGS && least > 0; ring++) for (const [right, down] of sides) {
      const gap = (away + ring * RING) * (right && down ? .8 : 1);
      const left = at[0] + right * gap + (right - 1) * wide / 2, top = at[1] + down * gap + (down - 1) * high / 2;
      /** @type {Box} */
      const box = [left, top, left + wide, top + high];
      const out = box.reduce((sum, v, k) => sum + Math.max(0, EDGE + (k < 2 ? bounds[k] - v : v - bounds[k])), 0);
      if (out > 0 && best && ring) continue;
      const cost = this.#covered(box) + 60 * out + 4 * ring;
      if (cost < least - 1e-9) [least, best] = [cost, box];
    }
    if (!best) return;
    const [left, top, right, bottom] = best;
    this.keepBox([left - 2, top - 1, right + 2, bottom + 1]);
    const near = [Math.min(Math.max(at[0], left), right), Math.min(Math.max(at[1], top), bottom)];
    const gap = Math.hypot(near[0] - at[0], near[1] - at[1]);
    if (gap > clear + LED) {
      const u = [(near[0] - at[0]) / gap, (near[1] - at[1]) / gap];
      this.html += `<path class="${lead}" d="M${px(at[0] + u[0] * clear * .8)} ${px(at[1] + u[1] * clear * .8)}L${
        px(near[0] - 2 * u[0])} ${px(near[1] - 2 * u[1])}"/>`;
    }
    this.html += `<text class="${kind} vi-b vi-halo" style="font-size:${size}px" x="${px(left + 1)}" y="${
      px(top + size * .93)}">${escaped(words)}</text>`;
  }

  /** @param {Box} box */
  #covered([left, top, right, bottom]) {
    let area = 0;
    for (const [a, b, c, d] of this.taken) {
      const w = Math.min(right, c) - Math.max(left, a), h = Math.min(bottom, d) - Math.max(top, b);
      if (w > 0 && h > 0) area += w * h;
    }
    return area;
  }
}
