/** Drawings of lessons: SVG as large as its box, in units that grow with the page's letters.
 * @typedef {[number, number]} Place in units of a drawing
 * @typedef {[number, number, number, number]} Rectangle left, top, right, bottom, in units of a drawing */
import {add, arrowPaths, drawingSize, escaped, px, set} from "../../view/svg.js";
export {circles, crosses, diamonds, dots, polyline} from "../../view/svg.js";

const LETTER_PX = 12.5; // size of letters, in units
const PILL_HIGH = 21, HEAD = 7.5; // units: of a pill, of an arrow's tip

let brush = /** @type {CanvasRenderingContext2D | null} */ (null);
const widths = /** @type {Map<string, number>} */ (new Map());

/** How wide words are, in units. @param {string} words @param {boolean} [bold] @param {number} [size] of letters */
export function widthOf(words, bold = false, size = LETTER_PX) {
  const font = `${bold ? 600 : 400} ${size}px Inter,system-ui,sans-serif`, key = font + words;
  let found = widths.get(key);
  if (found === undefined) {
    brush ??= /** @type {CanvasRenderingContext2D} */ (document.createElement("canvas").getContext("2d"));
    brush.font = font;
    widths.set(key, found = brush.measureText(words).width);
  }
  return found;
}

export class Drawing {
  /** @param {HTMLElement} box @param {string} kind class of the drawing @param {boolean} [isBare] without a frame */
  constructor(box, kind, isBare = true) {
    this.box = box;
    if (isBare) box.classList.add("bare");
    this.svg = add(box, "svg", {class: `vi ${isBare ? "lesson-drawing" : "draw-plane"} ${kind}`, role: "img"});
    this.unit = 1;
    this.width = 1;
    this.height = 1;
    this.last = "";
    this.measure();
  }

  /** The drawing takes the size of its box. */
  measure() {
    Object.assign(this, drawingSize(this.box));
    set(this.svg, {viewBox: `0 0 ${px(this.width)} ${px(this.height)}`});
  }

  /** @param {string} inside SVG @param {string} label the drawing in words */
  show(inside, label) {
    set(this.svg, {"aria-label": label});
    if (inside !== this.last) this.svg.innerHTML = this.last = inside;
  }
}

/** A figure that is one drawing.
 * @param {string} kind class of the drawing
 * @param {(drawing: Drawing, stage: import("../stage.js").Stage, layers: Set<string>) => [string, string]} write
 * SVG, and the drawing in words @returns {import("../stage.js").FigureKind["create"]} */
export const sketched = (kind, write) => box => {
  const drawing = new Drawing(box, kind);
  return {resize: () => drawing.measure(), draw: (stage, layers) => drawing.show(...write(drawing, stage, layers))};
};

/** Words, in which l and r are written as on the pictures.
 * @param {number} x @param {number} y of the base line @param {string} words @param {string} [kind] */
export const text = (x, y, words, kind = "") => `<text class="${kind}" x="${px(x)}" y="${px(y)}">${
  escaped(words).replace(/^(line from )?([lr])\b/, '$1<tspan class="eye">$2</tspan>')}</text>`;

/** @param {string} kind @param {string} d @param {string} [more] attributes */
export const path = (kind, d, more = "") => d ? `<path class="${kind}" d="${d}"${more}/>` : "";

/** @param {number[][][]} ends @param {number} [most] length of a tip @param {string} [kind] @param {string} [tip] */
export function arrows(ends, most = HEAD, kind = "vi-e", tip = "vi-tip") {
  const [shafts, tips] = arrowPaths(ends, most);
  return path(kind, shafts) + path(tip, tips);
}

/** Words on a pill beside the middle of a line, or on it, where nothing is yet.
 * @param {number[]} at @param {number[]} to @param {string} words @param {import("./names.js").Names} names */
export function pill(at, to, words, names) {
  const wide = widthOf(words, true) + 18, long = Math.hypot(to[0] - at[0], to[1] - at[1]);
  const [u, v] = long < 1 ? [1, 0] : [(to[0] - at[0]) / long, (to[1] - at[1]) / long];
  for (const away of [0, 26, -26, 44, -44, 66, -66, 90, -90, 130, -130]) {
    if (!away && long < wide + 60) continue;
    const x = (at[0] + to[0]) / 2 - v * away * (1 + Math.abs(v)), y = (at[1] + to[1]) / 2 + u * away;
    /** @type {Rectangle} */
    const box = [x - wide / 2, y - PILL_HIGH / 2, x + wide / 2, y + PILL_HIGH / 2];
    if (!names.isFree(box)) continue;
    names.keepBox(box);
    return `<rect class="lesson-pill" x="${px(box[0])}" y="${px(box[1])}" width="${px(wide)}" height="${PILL_HIGH}"
 rx="${PILL_HIGH / 2}"/>${text(x, y + 4.5, words, "lesson-pill-words vi-b vi-mid")}`;
  }
  return "";
}

/** Rows that explain lines or marks, beside each other where there is room, and their height.
 * @param {[string, string, string?][]} rows sample around (15, 0), 30 wide; words; classes of the words
 * @param {number} x @param {number} y of the first row's middle @param {number} width
 * @returns {{drawn: string, height: number}} */
export function legend(rows, x, y, width) {
  let left = x, row = 0, drawn = "";
  for (const [sample, words, kind] of rows) {
    const wide = 38 + widthOf(words, true) + 18;
    if (left > x && left + wide - 14 > x + width) [left, row] = [x, row + 1];
    const down = y + 19 * row;
    drawn += `<g transform="translate(${px(left)} ${px(down)})">${sample}</g>`;
    drawn += text(left + 37, down + 4.5, words, kind);
    left += wide;
  }
  return {drawn, height: rows.length ? 19 * (row + 1) : 0};
}

/** How high `legend` would be. @param {[string, string, string?][]} rows @param {number} width */
export const legendHeight = (rows, width) => legend(rows, 0, 0, width).height;

/** An axis: values to places.
 * @param {number} low @param {number} high @param {number} from place of the low value @param {number} to
 * @param {boolean} [logarithmic] */
export function axis(low, high, from, to, logarithmic = false) {
  const of = logarithmic ? Math.log : (/** @type {number} */ v) => v;
  return (/** @type {number} */ value) => from + (to - from) * (of(value) - of(low)) / (of(high) - of(low));
}

/** @param {string} kind @param {number} x @param {number} y @param {number} width @param {number} height
 * @param {number} [round] radius of the corners */
export const rectangle = (kind, x, y, width, height, round = 0) =>
  `<rect class="${kind}" x="${px(x)}" y="${px(y)}" width="${px(Math.max(width, 0))}" height="${px(Math.max(height, 0))}"
 rx="${round}"/>`;

/** A drawing that cuts off what leaves its box. @param {Rectangle} box @param {string} inside in the same units */
export const within = ([left, top, right, bottom], inside) => {
  const [x, y, width, height] = [left, top, Math.max(right - left, 1), Math.max(bottom - top, 1)].map(px);
  const size = `width="${width}" height="${height}" viewBox="${x} ${y} ${width} ${height}"`;
  return `<svg x="${x}" y="${y}" ${size}>${inside}</svg>`;
};

/** The part of a segment within a box.
 * @param {number[]} p @param {number[]} q @param {Rectangle} box @returns {[number, number][]} empty for none */
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

/** The box around points. @param {Iterable<ArrayLike<number>>} points @returns {Rectangle} */
export function around(points) {
  /** @type {Rectangle} */
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const p of points) {
    box[0] = Math.min(box[0], p[0]);
    box[1] = Math.min(box[1], p[1]);
    box[2] = Math.max(box[2], p[0]);
    box[3] = Math.max(box[3], p[1]);
  }
  return box;
}

/** From points to places in a rectangle, as large as fits. @param {number[][]} points @param {Rectangle} box */
export function fitted(points, [left, top, right, bottom]) {
  const [x0, y0, x1, y1] = around(points), scale = Math.min((right - left) / (x1 - x0), (bottom - top) / (y1 - y0));
  const place = (/** @type {number[]} */ [x, y]) =>
    [(left + right) / 2 + (x - (x0 + x1) / 2) * scale, (top + bottom) / 2 + (y - (y0 + y1) / 2) * scale];
  return {scale, place};
}

/** Powers of ten around values, and those that have room. @param {number[]} values @param {number} most ticks */
export function decades(values, most) {
  const first = Math.floor(Math.log10(Math.min(...values)));
  const last = Math.max(first + 1, Math.ceil(Math.log10(Math.max(...values))));
  const every = Math.ceil((last - first) / Math.max(1, most - 1)), ticks = [];
  for (let k = first; k <= last; k += every) ticks.push(Number(`1e${k}`));
  return {from: 10 ** first, to: 10 ** last, ticks};
}
