/**
 * A drawing with a window on something measured in its own unit: px of an image, px of a view from outside, metres of a
 * plan. The window can glide. Names find a free place.
 *
 * @typedef {{x: number, y: number, scale: number}} Window what lies at the drawing's corner, and drawing units per unit
 * @typedef {[number, number, number, number]} Box left, top, right, bottom
 */
import {add, drawingUnit, px, set} from "../../view/svg.js";

const GLIDE = 0.16; // share of its way that a window goes in a frame
const STILL = 0.3; // drawing units from where a window has arrived
const LETTERS = "Inter, system-ui, sans-serif";

export const isStill = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/** Text without what HTML would read. @param {string} text */
export const plain = text => text.replace(/[&<>"]/g, c => `&#${c.charCodeAt(0)};`);

export class Plane {
  /**
   * @param {HTMLElement} box
   * @param {string} [kind] class of the drawing
   */
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
    const unit = drawingUnit(), width = Math.max(this.box.clientWidth, 40) / unit;
    const height = Math.max(this.box.clientHeight, 40) / unit;
    if (unit === this.unit && width === this.width && height === this.height) return false;
    Object.assign(this, {unit, width, height});
    set(this.svg, {viewBox: `0 0 ${width} ${height}`});
    this.window = {...this.window, scale: 0};
    return true;
  }

  /**
   * Glide to a window that holds a box, centred.
   *
   * @param {Box} box
   * @param {{margin?: Box, most?: number, glide?: boolean}} [options] margin: drawing units that stay free; most: scale
   * @returns {boolean} whether the window has still to move
   */
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

  /**
   * The whole of a line a x + b y + c = 0 that the drawing shows.
   *
   * @param {{a: number, b: number, c: number}} line
   * @returns {[number, number][]} two places in drawing units
   */
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

  /** @param {string} html @param {string} label that says what is seen */
  show(html, label) {
    if (html !== this.last) this.ink.innerHTML = this.last = html;
    set(this.svg, {"aria-label": label});
  }
}

/**
 * The part of a segment within a box.
 *
 * @param {number[]} p
 * @param {number[]} q
 * @param {Box} box
 * @returns {[number, number][]} empty for none
 */
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

let /** @type {CanvasRenderingContext2D | null} */ ruler = null;

/** How wide a text is, drawing units. @param {string} text @param {number} size @param {number} weight */
export function widthOf(text, size, weight) {
  ruler ??= document.createElement("canvas").getContext("2d");
  if (!ruler) return .6 * size * text.length;
  ruler.font = `${weight} ${size}px ${LETTERS}`;
  return ruler.measureText(text).width;
}

const SIDES = [[1, -1], [1, 1], [-1, -1], [-1, 1], [0, -1], [0, 1], [1, 0], [-1, 0]]; // of a place, for its name
const MAX_RINGS = 8, RING = 14; // how far a name goes from its place, drawing units
const LED = 14; // from its place at which a name has a line to it

/** Names in a drawing that cover neither each other nor what has to be seen. */
export class Names {
  /** @param {number} width @param {number} height */
  constructor(width, height) {
    this.width = width;
    this.height = height;
    /** @type {Box[]} */
    this.taken = [];
    this.html = "";
  }

  /** Keep a place free. @param {ArrayLike<number>} p drawing units @param {number} radius */
  keep(p, radius) {
    if (Number.isFinite(p[0] + p[1])) this.taken.push([p[0] - radius, p[1] - radius, p[0] + radius, p[1] + radius]);
  }

  /** Keep a segment free. @param {ArrayLike<number>} p @param {ArrayLike<number>} q @param {number} [radius] */
  keepLine(p, q, radius = 2) {
    const part = clipped([p[0], p[1]], [q[0], q[1]], [0, 0, this.width, this.height]);
    if (!part.length) return;
    const [[a, b], [c, d]] = part, count = Math.ceil(Math.hypot(c - a, d - b) / 6);
    for (let k = 0; k <= count; k++) this.keep([a + (c - a) * k / (count || 1), b + (d - b) * k / (count || 1)],
      radius);
  }

  /** @param {Box} box */
  keepBox(box) {
    this.taken.push(box);
  }

  /**
   * A name near a place, where most room is left.
   *
   * @param {string} text
   * @param {ArrayLike<number>} at drawing units
   * @param {string} kind classes of the text
   * @param {{size?: number, weight?: number, away?: number, first?: number[]}} [options] away:
   *   from the place; first: side that is tried first
   */
  put(text, at, kind, {size = 13, weight = 600, away = 9, first} = {}) {
    const wide = widthOf(text, size, weight) + 2, high = size * 1.15;
    const sides = first ? [first, ...SIDES] : SIDES;
    let best = /** @type {Box | null} */ (null), least = Infinity;
    for (let ring = 0; ring < MAX_RINGS && least > 0; ring++) for (const [right, down] of sides) {
      const gap = away + ring * RING, slant = right && down ? .8 : 1;
      const left = at[0] + (right > 0 ? gap * slant : right < 0 ? -gap * slant - wide : -wide / 2);
      const top = at[1] + (down > 0 ? gap * slant : down < 0 ? -gap * slant - high : -high / 2);
      const box = /** @type {Box} */ ([left, top, left + wide, top + high]);
      const out = Math.max(0, 3 - left) + Math.max(0, 3 - top) + Math.max(0, left + wide + 3 - this.width)
        + Math.max(0, top + high + 3 - this.height);
      const cost = this.#covered(box) + 60 * out + 4 * ring;
      if (out > 0 && best && ring) continue;
      if (cost < least - 1e-9) [least, best] = [cost, box];
    }
    if (!best) return;
    const [left, top, right, bottom] = best;
    this.taken.push([left - 2, top - 1, right + 2, bottom + 1]);
    const near = [Math.min(Math.max(at[0], left), right), Math.min(Math.max(at[1], top), bottom)];
    const gap = Math.hypot(near[0] - at[0], near[1] - at[1]);
    if (gap > away + LED) {
      const u = [(near[0] - at[0]) / gap, (near[1] - at[1]) / gap];
      this.html += `<path class="draw-lead" d="M${px(at[0] + u[0] * away * .8)} ` +
        `${px(at[1] + u[1] * away * .8)}L${px(near[0] - 2 * u[0])} ${px(near[1] - 2 * u[1])}"/>`;
    }
    this.html += `<text class="${kind} vi-halo" style="font-size:${size}px;font-weight:${weight}" ` +
      `x="${px(left + 1)}" y="${px(top + size * .93)}">${plain(text)}</text>`;
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

/** @param {number} x @param {number} y @param {number} r */
export const disc = (x, y, r) => `M${px(x - r)} ${px(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`;

/** @param {number} x @param {number} y @param {number} r */
export const diamond = (x, y, r) => `M${px(x - r)} ${px(y)}l${r} ${-r} ${r} ${r} ${-r} ${r}z`;

/**
 * An arrow as a shaft and a tip.
 *
 * @param {ArrayLike<number>} from
 * @param {ArrayLike<number>} to
 * @param {number} [tip] its length
 * @returns {[string, string]} paths, both empty for none
 */
export function arrow(from, to, tip = 6) {
  const dx = to[0] - from[0], dy = to[1] - from[1], length = Math.hypot(dx, dy);
  if (!(length > .5)) return ["", ""];
  const size = Math.min(tip, length * .7), u = dx / length * size, v = dy / length * size;
  const shaft = `M${px(from[0])} ${px(from[1])}L${px(to[0] - u * .8)} ${px(to[1] - v * .8)}`;
  return [shaft, `M${px(to[0])} ${px(to[1])}L${px(to[0] - u - v * .5)} ` +
    `${px(to[1] - v + u * .5)}L${px(to[0] - u + v * .5)} ${px(to[1] - v - u * .5)}z`];
}
