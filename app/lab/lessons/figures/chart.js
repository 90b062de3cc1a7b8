/** Curves over two axes, named where they end.
 * @typedef {Object} Curve
 * @property {number[][]} points x and y; y that is not finite makes a gap
 * @property {string} role one of the roles of figures.css: learner, opponent, plain, demonstrator, E
 * @property {string} [name]
 * @property {number} [shown] how many of its points are drawn yet, all by default
 * @property {boolean} [line] false for dots alone
 * @property {boolean[]} [hollow] points that are drawn hollow
 * @property {number} [named] the point beside which its name stands, the last one by default
 * @typedef {{x: [number, number], y: [number, number], log?: boolean, xTicks: [number, string][],
 * xName?: string, yName?: string, levels?: [number, string, string][]}} Axes x: least and most; log: whether y is
 * logarithmic; levels: a y with its name and role, as a line across
 * @import {Stage, FigureKind} from "../stage.js" */
import {escaped, px} from "../../view/svg.js";
import {short} from "../measured.js";
import {circles, widthOf} from "./drawing.js";
import {Names} from "./names.js";
import {Plane} from "./plane.js";

const TICK = 12, NAME = 13; // letters, drawing units
const MOST_DOTS = 80; // of a curve, of which each point is drawn
const ROOM = 20; // over the axes, for the name of y
const LOW = 104, LINE = 15; // a drawing that is lower has a list of names beside its curves, and no ticks under a half; a line of that list
const MIN_TICK_GAP = 16; // units, of ticks of y

export class Chart {
  /** @param {HTMLElement} box */
  constructor(box) { this.plane = new Plane(box, "draw-chart"); }

  resize() { this.plane.measure(); }

  /** @param {Axes} axes @param {Curve[]} curves @param {string} label */
  draw(axes, curves, label) {
    const {width, height} = this.plane, names = new Names([0, 0, width, height]), isLow = height < LOW;
    const ticks = height < LOW / 2 ? [] : round(axes.y, axes.log);
    const list = isLow ? curves.filter(({name, role}) => name && role !== "bar") : [];
    const listed = list.length ? Math.max(...list.map(({name = ""}) => widthOf(name, true, TICK))) + 22 : 0;
    const left = ticks.length && 14 + Math.max(...ticks.map(value => widthOf(tickText(value), false, TICK)));
    const box = isLow ? [left || 6, 12, width - 8 - listed, height - 8]
      : [left, 10 + (axes.yName ? ROOM : 0), width - 14, height - (axes.xName ? 36 : 22)];
    const up = (/** @type {number} */ v) => axes.log ? Math.log(Math.max(v, 1e-12)) : v, [low, high] = axes.y.map(up);
    const x = (/** @type {number} */ v) => box[0] + (v - axes.x[0]) / (axes.x[1] - axes.x[0]) * (box[2] - box[0]);
    const y = (/** @type {number} */ v) =>
      box[3] - Math.min(1.02, Math.max(-.02, (up(v) - low) / (high - low))) * (box[3] - box[1]);
    let html = "";
    const text = (/** @type {number} */ a, /** @type {number} */ b, /** @type {string} */ words,
      /** @type {string} */ kind) => {
      html += `<text class="${kind}" style="font-size:${TICK}px" x="${px(a)}" y="${px(b)}">${escaped(words)}</text>`;
    };
    let under = Infinity;
    for (const value of ticks) {
      if (under - y(value) < MIN_TICK_GAP) continue;
      under = y(value);
      html += `<path class="vi-rule" d="M${px(box[0])} ${px(y(value))}H${px(box[2])}"/>`;
      text(box[0] - 6, y(value) + 4, tickText(value), "vi-2nd vi-end");
    }
    let free = -Infinity;
    for (const [value, words] of isLow ? [] : axes.xTicks) {
      const wide = widthOf(words, false, TICK), at = Math.min(width - wide / 2 - 2, Math.max(wide / 2 + 2, x(value)));
      if (at - wide / 2 < free) continue;
      free = at + wide / 2 + 8;
      html += `<path class="vi-axis" d="M${px(x(value))} ${px(box[3])}v4"/>`;
      text(at, box[3] + 16, words, "vi-2nd vi-mid");
    }
    if (isLow) html += `<path class="vi-rule" d="M${px(box[0])} ${px(box[3])}H${px(box[2])}"/>`;
    if (axes.yName && !isLow) text(4, 15, axes.yName, "draw-ink vi-b");
    if (axes.xName && !isLow) text(width - 6, height - 6, axes.xName, "vi-2nd vi-end");
    const drawn = curves.map(curve => ({...curve, at: curve.points.slice(0, curve.shown ?? curve.points.length)
      .filter(p => Number.isFinite(p[1])).map(p => [x(p[0]), y(p[1])])})).filter(({at}) => at.length);
    for (const {at} of drawn) {
      names.keep(at[0], 4);
      names.keepLine(at);
    }
    names.keepBox([0, box[3], width, height]);
    names.keepBox([0, 0, box[0], height]);
    for (const [value, words, role] of axes.levels ?? []) {
      html += `<path class="draw-level draw-of-${role}" d="M${px(box[0])} ${px(y(value))}H${px(box[2])}"/>`;
      names.keepLine([[box[0], y(value)], [box[2], y(value)]], 2);
      if (!isLow) names.put(words, [box[2] - widthOf(words, true, TICK) / 2 - 4, y(value)], `draw-name-${role}`,
        {size: TICK, away: 5, first: [0, -1]});
    }
    for (const {at, role, hollow = [], line = true, points} of drawn) {
      const d = `M${at.map(p => p.map(px).join(" ")).join("L")}`;
      if (line) html += `<path class="draw-curve draw-of-${role}" d="${d}"/>`;
      if (points.length <= MOST_DOTS) for (const isHollow of [false, true]) {
        const some = at.filter((_, k) => Boolean(hollow[k]) === isHollow);
        html += `<path class="draw-dots draw-of-${role}${isHollow ? " draw-hollow" : ""}" ` +
          `d="${circles(some, line ? 2.4 : 4.6)}"/>`;
      }
    }
    list.forEach(({name = "", role}, k) => {
      const b = height / 2 + LINE * (k - (list.length - 1) / 2);
      html += `<path class="draw-curve draw-of-${role}" d="M${px(width - listed)} ${px(b)}h14"/>`;
      text(width - listed + 18, b + 4, name, `draw-name-${role} vi-b`);
    });
    for (const {at, role, name, named} of drawn) if (name && (!isLow || role === "bar"))
      names.put(name, at[Math.min(named ?? at.length - 1, at.length - 1)], `draw-name-${role}`,
        {size: NAME, away: 8, first: [0, -1]});
    this.plane.show(html + names.html, label);
  }
}

/** A figure that is one chart, by what `draw` takes.
 * @param {(stage: Stage, layers: Set<string>) => [Axes, Curve[], string]} drawn @returns {FigureKind["create"]} */
export const charted = drawn => box => {
  const chart = new Chart(box);
  return {resize: () => chart.resize(), draw: (stage, layers) => chart.draw(...drawn(stage, layers))};
};

/** @param {number} value */
const tickText = value => value >= 1000 ? value.toLocaleString("en").replace(",", " ") : value === 0 ? "0"
  : short(value).replace(/\.0+$/, "");

/** Round numbers between two: some four, or powers of ten. @param {[number, number]} range @param {boolean} [log] */
export function round([low, high], log = false) {
  const found = [];
  if (log) {
    const decades = Math.log10(high / low), factors = decades > 2.5 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 5];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) for (const factor of factors) {
      const value = factor * 10 ** power;
      if (value >= low * .999 && value <= high * 1.001) found.push(Number(value.toPrecision(3)));
    }
    return found;
  }
  const rough = (high - low) / 4, size = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(k => k * size).find(each => each >= rough) ?? 10 * size;
  for (let value = Math.ceil(low / step) * step; value <= high
    + 1e-9; value += step) found.push(Number(value.toPrecision(6)));
  return found;
}

/** Steps as ticks. @param {number} last @returns {[number, string][]} */
export const stepTicks = last => round([0, last]).filter(Number.isInteger).map(value => [value, String(value)]);
