/** Where two lines cross, through a magnifying glass: pixels are squares, one line is also drawn one pixel away, and
 * the ellipse holds the transferred point if pixels are off.
 * @import {Stage, FigureKind} from "../stage.js" @import {Fitted} from "../../engine/transfers.js" @import {Line} from "../../engine/affine.js"
 * @typedef {{lines: [Line, Line], at: number[], moved: Line, movedAt: number[]}} Crossing px in L: lines from l
 * and r, where they cross, and the same with the second one moved by a pixel
 * @typedef {{at: number[], halfAxes: number[], direction: number}} Ellipse px, the longer half axis first; rad */
import {fixed, px} from "../../view/svg.js";
import {
  arrows, diamonds, Drawing, legend, legendHeight, path, pill, polyline, rectangle, sketched, text, within,
} from "./drawing.js";
import {Names} from "./names.js";

const MOST_PX = 8, ROOM = .36; // units a pixel at most; share of a side that the way of the crossing may take
const HEAD = 24, GAP = 14;
const FD_STEP_PX = .5, CHI2_95 = -2 * Math.log(.05); // the 95 % quantile of χ² with two degrees of freedom

/** @type {FigureKind} */
export const CROSSING = {
  layers: ["lines", "moved line", "ellipse"],
  title: "**L**, enlarged",
  aspect: .95,
  create: sketched("lesson-crossing", (drawing, stage, layers) => {
    const found = crossingOf(stage);
    return found ? [drawn(drawing, stage, layers, found), described(found, layers)]
      : [text(0, 60, "Too few points are seen.", "vi-2nd"), "No lines: too few points are seen."];
  }),
};

/** Of the step's point; null without lines. @param {Stage} stage @returns {Crossing | null} */
export function crossingOf(stage) {
  const l = stage.line(0), r = stage.line(1);
  if (!l || !r) return null;
  const moved = {...r, c: r.c + 1};
  return {lines: [l, r], at: meeting(l, r), moved, movedAt: meeting(l, moved)};
}

/** @param {Line} p @param {Line} q */
function meeting(p, q) {
  const w = p.a * q.b - p.b * q.a;
  return [(p.b * q.c - p.c * q.b) / w, (p.c * q.a - p.a * q.c) / w];
}

/** Degrees between two lines, up to 90. @param {Crossing} crossing */
export const angleOf = ({lines: [p, q]}) => Math.asin(Math.min(1, Math.abs(p.a * q.b - p.b * q.a))) * 180 / Math.PI;

/** How far a pixel moves the crossing, px. @param {Crossing} crossing */
export const shiftOf = ({at, movedAt}) => Math.hypot(movedAt[0] - at[0], movedAt[1] - at[1]);

/** In which a transferred point lies, 19 times of 20, if each coordinate in l and r is off by a pixel (one standard
 * deviation).
 * @param {Stage} stage @param {number} [side] 0 for L, 1 for R @returns {Ellipse | null} null without a transfer */
export function ellipseOf(stage, side = 0) {
  const {fitted, views, usable} = stage.moment, {chosen} = stage;
  if (!fitted || !usable.includes(chosen)) return null;
  return spreadOf(fitted, views.demo.subarray(4 * chosen, 4 * chosen + 4))[side];
}

/** The same in L and R, of any point. @param {Fitted} fitted
 * @param {Float64Array} at its x, y in l and r, px @param {number} [noisePx] @returns {Ellipse[]} */
export function spreadOf(fitted, at, noisePx = 1) {
  const near = new Float64Array(36);
  for (let k = 0; k < 9; k++) for (let c = 0; c < 4; c++)
    near[4 * k + c] = at[c] + (k < 4 && c === k ? FD_STEP_PX : k < 8 && c === k - 4 ? -FD_STEP_PX : 0);
  const found = fitted.recover(near);
  return [0, 2].map(x => {
    let xx = 0, xy = 0, yy = 0;
    for (let k = 0; k < 4; k++) {
      const u = found[4 * k + x] - found[4 * k + 16 + x], v = found[4 * k + x + 1] - found[4 * k + 17 + x];
      [xx, xy, yy] = [xx + u * u, xy + u * v, yy + v * v];
    }
    const mean = (xx + yy) / 2, radius = Math.hypot((xx - yy) / 2, xy), longest = mean + radius;
    const shortest = longest > 0 ? (xx * yy - xy * xy) / longest : 0; // mean - radius would cancel
    const halfAxes = [longest, Math.max(shortest, 0)].map(v => noisePx * Math.sqrt(CHI2_95 * v) / (2 * FD_STEP_PX));
    return {at: [found[32 + x], found[33 + x]], halfAxes, direction: Math.atan2(2 * xy, xx - yy) / 2};
  });
}

/** @param {number[]} at @param {number[]} halfAxes in units of the drawing @param {number} direction rad */
export const drawnEllipse = (at, [a, b], direction) => `<ellipse class="vi-spread" rx="${px(a)}" ry="${
  px(Math.max(b, 1))}" transform="translate(${px(at[0])} ${px(at[1])})rotate(${px(direction * 180 / Math.PI)})"/>`;

/** @param {Drawing} drawing @param {Stage} stage @param {Set<string>} layers @param {Crossing} found */
function drawn({width, height}, stage, layers, found) {
  const rows = /** @type {[string, string][]} */ ([]);
  if (layers.has("lines")) rows.push([path("vi-line lesson-line", "M0 0h30"), "line from l"],
    [path("vi-line lesson-line vi-from-right", "M0 0h30"), "line from r"]);
  if (layers.has("moved line")) rows.push([path("lesson-line-moved", "M0 0h30"), "line from r, moved by one pixel"]);
  rows.push([path("vi-found", diamonds([[15, 0]], 6)), "crossing"]);
  if (layers.has("ellipse")) rows.push([drawnEllipse([15, 0], [14, 5.5], 0), "transferred point, 19 times of 20"]);
  rows.push([path("lesson-pixels lesson-pixel", "M9-6h12v12h-12z"), "one pixel"]);
  const bottom = height - legendHeight(rows, width) - GAP, size = [width - 1, bottom - HEAD];
  const middle = [width / 2, (HEAD + bottom) / 2], way = found.movedAt.map((v, k) => Math.abs(v - found.at[k]));
  const scale = Math.min(MOST_PX, ...size.map((v, k) => ROOM * v / Math.max(way[k], 1e-9)));
  const place = (/** @type {number[]} */ p) => p.map((v, k) => (v - found.at[k]) * scale + middle[k]);
  const names = new Names([4, HEAD + 4, width - 4, bottom - 4]);
  let svg = pixels(found.at, scale, size, middle);
  const spread = layers.has("ellipse") ? ellipseOf(stage) : null;
  if (spread) svg += drawnEllipse(middle, spread.halfAxes.map(v => v * scale), spread.direction);
  const strokes = /** @type {[Line, string][]} */ ([]);
  if (layers.has("lines")) strokes.push([found.lines[0], "vi-line lesson-line"],
    [found.lines[1], "vi-line lesson-line vi-from-right"]);
  if (layers.has("moved line")) strokes.push([found.moved, "lesson-line-moved"]);
  for (const [line, kind] of strokes) {
    const ends = chord(line, found.at, Math.hypot(...size) / scale).map(place);
    names.keepLine(ends, 2);
    svg += path(kind, polyline(ends));
  }
  if (layers.has("moved line")) {
    const from = place(found.at), to = place(found.movedAt);
    names.keepLine([from, to], 8);
    svg += `<g class="lesson-large-arrow">${arrows([[from, to]], 12)}</g>`;
    svg += pill(from, to, `${fixed(shiftOf(found))} px`, names);
  }
  svg += path("vi-found lesson-found", diamonds([middle], 7));
  const plane = rectangle("vi-plane", .5, HEAD, size[0], size[1], 5) + within([.5, HEAD, .5 + size[0], bottom], svg);
  return `${plane}${text(0, 16, `The lines cross at ${fixed(angleOf(found))}°`, "vi-b")}${
  legend(rows, 0, bottom + GAP + 4, width).drawn}`;
}

/** Two points of a line, far from a place. @param {Line} line @param {number[]} at @param {number} far px */
function chord({a, b, c}, [x, y], far) {
  const off = a * x + b * y + c, foot = [x - a * off, y - b * off];
  return [[foot[0] - b * far, foot[1] + a * far], [foot[0] + b * far, foot[1] - a * far]];
}

/** The grid of pixels. @param {number[]} at @param {number} scale @param {number[]} size @param {number[]} middle */
function pixels(at, scale, size, middle) {
  if (scale < 2.5) return "";
  const [left, top] = size.map((v, k) => middle[k] - v / 2), [w, h] = size.map(v => v / 2 / scale);
  let d = "";
  for (let x = Math.ceil(at[0] - w); x < at[0] + w; x++)
    d += `M${px((x - at[0]) * scale + middle[0])} ${px(top)}v${px(size[1])}`;
  for (let y = Math.ceil(at[1] - h); y < at[1] + h; y++)
    d += `M${px(left)} ${px((y - at[1]) * scale + middle[1])}h${px(size[0])}`;
  return path("lesson-pixels", d);
}

/** @param {Crossing} found @param {Set<string>} layers */
function described(found, layers) {
  const words = [`Image L, enlarged: the lines from l and from r cross at ${fixed(angleOf(found))}°`];
  if (layers.has("moved line"))
    words.push(`with the line from r moved by one pixel, the crossing is ${fixed(shiftOf(found))} px away`);
  if (layers.has("ellipse")) words.push("an ellipse along both lines holds the transferred point, 19 times of 20");
  return `${words.join("; ")}.`;
}
