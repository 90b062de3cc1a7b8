/**
 * Where E was smallest under noise, time for time: clouds of postures about the demonstrator's, over lines of equal E.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").FigureKind} FigureKind
 */
import {Landscape} from "../../engine/engine.js";
import {contour} from "../../view/map.js";
import {fixed, px} from "../../view/svg.js";
import {Altered} from "../maps.js";
import {axis, crossHair, diamonds, dots, Drawing, Names, path, text} from "./drawing.js";

const DEGREE = Math.PI / 180, ROOM = 1.06; // of the posture that is farthest
const LEFT = 52, TOP = 26, RIGHT = 12, FOOT = 42;
const STEPS = 60, RINGS = 7; // of the map within the drawing; lines of equal E
const SHOWN = /** @type {const} */ (["one", "averaged"]);
const TITLES = {one: "one image each time", averaged: "25 images averaged each time"};

/** @type {FigureKind} */
export const CLOUDS = {
  layers: ["contours", "one", "averaged", "spread"],
  title: "Where E was smallest",
  unit: "rad",
  aspect: 1.35,
  create(box) {
    const drawing = new Drawing(box, "lesson-clouds");
    /** @type {{world: Altered | null, key: string, lines: string}} */
    const known = {world: null, key: "", lines: ""};
    return {
      resize: () => drawing.measure(),
      draw(stage, layers) {
        drawing.show(drawn(drawing, stage, layers, known), described(stage, layers));
      },
      place(stage, [first, second]) {
        const {x, y} = scales(drawing, stage);
        return [x(second) * drawing.unit, y(first) * drawing.unit];
      },
      unplace(stage, [across, down]) {
        const {low, high} = scales(drawing, stage), {width, height, unit} = drawing;
        const right = (across / unit - LEFT) / (width - LEFT - RIGHT), up = (height - FOOT - down / unit) / (height - FOOT - TOP);
        return [low[0] + up * (high[0] - low[0]), low[1] + right * (high[1] - low[1])];
      },
    };
  },
};

/** One scale for both joints, wide enough for all clouds. @param {Drawing} drawing @param {Stage} stage */
function scales({width, height}, stage) {
  /** @type {Record<string, number[][]>} */
  const clouds = stage.records.clouds, demo = stage.moment.thetaDemo, all = Object.values(clouds).flat();
  const most = demo.map((v, k) => ROOM * Math.max(...all.map(theta => Math.abs(theta[k] - v))));
  const right = width - RIGHT, bottom = height - FOOT;
  const perUnit = Math.max(2 * most[0] / (bottom - TOP), 2 * most[1] / (right - LEFT));
  const half = [perUnit * (bottom - TOP) / 2, perUnit * (right - LEFT) / 2];
  const low = demo.map((v, k) => v - half[k]), high = demo.map((v, k) => v + half[k]);
  return {low, high, x: axis(low[1], high[1], LEFT, right), y: axis(low[0], high[0], bottom, TOP), right, bottom};
}

/** @param {Drawing} drawing @param {Stage} stage @param {Set<string>} layers @param {{world: Altered | null, key: string, lines: string}} known */
function drawn(drawing, stage, layers, known) {
  const {low, high, x, y, right, bottom} = scales(drawing, stage), {names: joints} = stage.world.scene;
  const at = (/** @type {ArrayLike<number>} */ theta) => [x(theta[1]), y(theta[0])], demo = at(stage.moment.thetaDemo);
  const plane = `x="${LEFT}" y="${TOP}" width="${px(right - LEFT)}" height="${px(bottom - TOP)}"`;
  let svg = `<rect class="vi-plane" ${plane}/>`;
  for (const k of [0, 1]) for (const degrees of nice(low[k] / DEGREE, high[k] / DEGREE)) {
    const words = `${fixed(degrees, degrees % 1 ? 1 : 0)}°`;
    if (k) svg += path("vi-axis", `M${px(x(degrees * DEGREE))} ${px(bottom)}v4`) + text(x(degrees * DEGREE), bottom + 17, words, "vi-2nd vi-mid");
    else svg += path("vi-axis", `M${LEFT} ${px(y(degrees * DEGREE))}h-4`) + text(LEFT - 7, y(degrees * DEGREE) + 4.5, words, "vi-2nd vi-end");
  }
  svg += text((LEFT + right) / 2, bottom + 34, joints[1], "vi-2nd vi-mid") + text(4, 16, joints[0], "vi-2nd");
  if (layers.has("contours")) svg += `<svg ${plane} viewBox="${LEFT} ${TOP} ${px(right - LEFT)} ${px(bottom - TOP)}">${
    path("vi-contour", rings(stage, low, high, [LEFT, TOP, right, bottom], known))}</svg>`;
  const shown = SHOWN.filter(name => layers.has(name) && stage.records.clouds[name]), names = new Names(LEFT, TOP, right, bottom);
  for (const name of shown) svg += path(`lesson-cloud lesson-cloud-${name}`, dots(stage.records.clouds[name].map(at)));
  shown.forEach((name, row) => {
    const down = TOP + 20 + 20 * row;
    svg += path(`lesson-cloud-key lesson-cloud-${name}`, `M${LEFT + 14} ${down - 4.5}h0`);
    svg += text(LEFT + 26, down, TITLES[name], "vi-b vi-halo");
    names.take([LEFT, down - 16, LEFT + 260, down + 4]);
  });
  if (layers.has("spread")) svg += shown.map((name, row) => spread(stage.records.clouds[name], name, row, x, y, right, bottom)).join("");
  const {ask} = stage.step, you = ask.kind === "place" && ask.figure === "clouds" && stage.mark ? at(stage.mark) : null;
  if (you) svg += crossHair(you);
  svg += path("vi-seen", diamonds([demo], 6.5));
  names.takePoint(demo, 9);
  if (!shown.length) svg += names.beside(demo, "demonstrator", "vi-of-demo");
  return svg;
}

/**
 * Lines of equal E, undisturbed: near its smallest they are ellipses, equally far from each other.
 *
 * @param {Stage} stage
 * @param {number[]} low rad
 * @param {number[]} high
 * @param {number[]} box units
 * @param {{world: Altered | null, key: string, lines: string}} known
 */
function rings(stage, low, high, [left, top, right, bottom], known) {
  const {transfer} = stage.session.settings, demo = stage.world.look("demonstrator", stage.moment.thetaDemo);
  const key = [transfer, ...low, ...high, right, bottom].join();
  if (known.world?.of === stage.world && known.key === key) return known.lines;
  const map = new Altered(stage.world, {lower: low, upper: high}), deg = Math.min(...low.map((v, k) => high[k] - v)) / DEGREE;
  const landscape = new Landscape(map, deg / STEPS);
  landscape.evaluate(transfer, demo);
  const {E, axes} = landscape, rows = axes[0].length, columns = axes[1].length;
  const edge = [Math.floor(rows / 2) * columns, Math.floor(columns / 2)].map(g => E[g]), least = landscape.minimum?.E ?? 0;
  let d = "";
  for (let k = 1; k <= RINGS; k++) contour(E, rows, columns, least + (Math.max(...edge) - least) * (k / RINGS) ** 2, (a, b, c, e) => {
    const X = (/** @type {number} */ j) => px(left + (right - left) * j / (columns - 1));
    const Y = (/** @type {number} */ i) => px(bottom - (bottom - top) * i / (rows - 1));
    d += `M${X(a)} ${Y(b)}L${X(c)} ${Y(e)}`;
  });
  Object.assign(known, {world: map, key, lines: d});
  return d;
}

/** A bracket at the right and one below: a standard deviation to both sides of the middle. @param {number[][]} cloud @param {string} name @param {number} row @param {(v: number) => number} x @param {(v: number) => number} y @param {number} right @param {number} bottom */
function spread(cloud, name, row, x, y, right, bottom) {
  const mean = [0, 1].map(k => cloud.reduce((sum, theta) => sum + theta[k], 0) / cloud.length);
  const off = mean.map((v, k) => Math.sqrt(cloud.reduce((sum, theta) => sum + (theta[k] - v) ** 2, 0) / cloud.length));
  const across = right - 18 - 92 * row, down = bottom - 18 - 24 * row, words = off.map(v => `± ${fixed(v / DEGREE)}°`);
  const [low, high] = [-1, 1].map(sign => y(mean[0] + sign * off[0])), [first, last] = [-1, 1].map(sign => x(mean[1] + sign * off[1]));
  const d = `M${px(across)} ${px(low)}V${px(high)}M${px(across - 5)} ${px(low)}h10M${px(across - 5)} ${px(high)}h10M${px(first)} ${
    px(down)}H${px(last)}M${px(first)} ${px(down - 5)}v10M${px(last)} ${px(down - 5)}v10`;
  const kind = `vi-b vi-halo lesson-cloud-words-${name}`;
  return path(`lesson-bracket lesson-cloud-${name}`, d) + text(across - 9, (low + high) / 2 + 4.5, words[0], `${kind} vi-end`)
    + text(last + 9, down + 4.5, words[1], kind);
}

/** Round numbers between two, some six. @param {number} low @param {number} high */
function nice(low, high) {
  const step = [.1, .2, .5, 1, 2, 5, 10, 20, 30, 45].find(each => (high - low) / each <= 7) ?? 90, found = [];
  for (let k = Math.ceil(low / step); k * step <= high; k++) found.push(Math.round(k * step * 10) / 10);
  return found;
}

/** @param {Stage} stage @param {Set<string>} layers */
function described(stage, layers) {
  const {names} = stage.world.scene, words = [`Where E was smallest under noise: ${names[0]} upwards, ${names[1]} to the right`];
  for (const name of SHOWN) {
    const cloud = stage.records.clouds[name];
    if (!layers.has(name) || !cloud) continue;
    const off = [0, 1].map(k => {
      const mean = cloud.reduce((/** @type {number} */ sum, /** @type {number[]} */ theta) => sum + theta[k], 0) / cloud.length;
      return Math.sqrt(cloud.reduce((/** @type {number} */ sum, /** @type {number[]} */ theta) => sum + (theta[k] - mean) ** 2, 0) / cloud.length);
    });
    words.push(`with ${TITLES[name]} it spreads by ${fixed(off[0] / DEGREE)}° and ${fixed(off[1] / DEGREE)}°`);
  }
  return `${words.join("; ")}.`;
}
