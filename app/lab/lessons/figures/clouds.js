/** Where E was smallest under noise, time for time: clouds of postures about the demonstrator's, over lines of equal E.
 * @import {Stage, FigureKind} from "../stage.js"
 * @typedef {ReturnType<typeof scales>} Scales */
import {DEGREE, Landscape} from "../../engine/engine.js";
import {contour, nice} from "../../view/map.js";
import {fixed, px} from "../../view/svg.js";
import {Altered, smallest} from "../maps.js";
import {once} from "../../view/once.js";
import {axis, circles, crosses, diamonds, dots, Drawing, legend, legendHeight, path, polyline, rectangle, text,
  within} from "./drawing.js";
import {Names} from "./names.js";

const ROOM = 1.06; // of the posture that is farthest
const LEFT = 52, TOP = 26, RIGHT = 12, FOOT = 44; // units
const STEPS = 60, RINGS = 7; // of the map within the drawing; lines of equal E
const TITLES = {one: "one picture each time", averaged: "25 pictures averaged each time"};
const SHOWN = /** @type {const} */ (["one", "averaged"]);

/** @type {FigureKind} */
export const CLOUDS = {
  layers: ["contours", "one", "averaged", "spread", "middle", "bias"],
  title: "Where E was smallest, a dot each time",
  unit: "rad",
  aspect: 1.35,
  create(box) {
    const drawing = new Drawing(box, "lesson-clouds");
    return {
      resize: () => drawing.measure(),
      draw: (stage, layers) => drawing.show(drawn(drawing, stage, layers), described(stage, layers)),
      place(stage, [first, second]) {
        const {x, y} = scales(drawing, stage);
        return [x(second) * drawing.unit, y(first) * drawing.unit];
      },
      unplace(stage, [across, down]) {
        const {low, high, right, bottom} = scales(drawing, stage), {unit} = drawing;
        return [axis(bottom, TOP, low[0], high[0])(down / unit), axis(LEFT, right, low[1], high[1])(across / unit)];
      },
    };
  },
};

/** Those that the step ever shows. @param {Stage} stage @returns {Record<string, number[][]>} by name */
function cloudsOf({step, records}) {
  const uses = [...step.main ?? [], ...step.side ?? []].filter(({figure}) => figure === "clouds");
  const layers = uses.flatMap(({show = [], reveal = []}) => [...show, ...reveal]);
  return Object.fromEntries(SHOWN.filter(name => layers.includes(name)).map(name => [name, records.clouds[name]]));
}

/** Mean and standard deviation of both joints, rad. @param {number[][]} cloud */
function meanAndStd(cloud) {
  const mean = [0, 1].map(k => cloud.reduce((sum, theta) => sum + theta[k], 0) / cloud.length);
  const off = mean.map((v, k) => Math.sqrt(cloud.reduce((sum, theta) => sum + (theta[k] - v) ** 2, 0) / cloud.length));
  return {mean, off};
}

/** @param {Stage} stage @param {Set<string>} [layers] of which rows explain some */
function rowsOf(stage, layers) {
  /** @type {[string, string, string?][]} */
  const rows = SHOWN.filter(name => cloudsOf(stage)[name] && (!layers || layers.has(name))).map(name =>
    [path(`lesson-cloud-key lesson-cloud-${name}`, "M15 0h0"), TITLES[name], "vi-b"]);
  if (!layers || layers.has("contours")) rows.push([path("vi-contour", "M0 0h30"), "equal E, without noise"]);
  return rows;
}

/** One scale for both joints, wide enough for all clouds. @param {Drawing} drawing @param {Stage} stage */
function scales({width, height}, stage) {
  const demo = stage.moment.thetaDemo, all = Object.values(cloudsOf(stage)).flat();
  const most = demo.map((v, k) => ROOM * Math.max(...all.map(theta => Math.abs(theta[k] - v))));
  const right = width - RIGHT, bottom = height - FOOT - legendHeight(rowsOf(stage), width);
  const perUnit = Math.max(2 * most[0] / (bottom - TOP), 2 * most[1] / (right - LEFT));
  const half = [perUnit * (bottom - TOP) / 2, perUnit * (right - LEFT) / 2];
  const low = demo.map((v, k) => v - half[k]), high = demo.map((v, k) => v + half[k]);
  return {low, high, x: axis(low[1], high[1], LEFT, right), y: axis(low[0], high[0], bottom, TOP), right, bottom};
}

/** @param {Drawing} drawing @param {Stage} stage @param {Set<string>} layers */
function drawn(drawing, stage, layers) {
  const to = scales(drawing, stage), {x, y, right, bottom} = to, clouds = cloudsOf(stage);
  const at = (/** @type {ArrayLike<number>} */ theta) => [x(theta[1]), y(theta[0])], demo = at(stage.moment.thetaDemo);
  const names = new Names([LEFT, TOP, right, bottom]), shown = SHOWN.filter(name => layers.has(name) && clouds[name]);
  let inside = layers.has("contours") ? path("vi-contour", rings(stage, to)) : "";
  for (const name of shown) inside += path(`lesson-cloud lesson-cloud-${name}`, dots(clouds[name].map(at)));
  let svg = rectangle("vi-plane", LEFT, TOP, right - LEFT, bottom - TOP) + within([LEFT, TOP, right, bottom], inside);
  svg += ticks(to, stage.world.scene.names);
  svg += legend(rowsOf(stage, layers), 4, bottom + FOOT + 8, drawing.width).drawn;
  if (layers.has("spread")) shown.forEach((name, row) => svg += spread(clouds[name], name, row, to, names));
  names.keep(demo, 9);
  for (const name of shown) for (const theta of clouds[name]) names.keep(at(theta), 2);
  const middle = layers.has("middle") && clouds.averaged ? at(meanAndStd(clouds.averaged).mean) : null;
  const lowest = layers.has("bias") ? smallest(...undisturbed(stage)) : null, cross = lowest && at(lowest);
  for (const each of [middle, cross]) if (each) names.keep(each, 10);
  if (cross) svg += path("lesson-gap", polyline([cross, demo]));
  svg += path("vi-seen", diamonds([demo], 6.5));
  if (middle) svg += path("lesson-middle-case", circles([middle], 8)) + path("lesson-middle", circles([middle], 8));
  if (cross) svg += path("lesson-cross-case", crosses([cross], 7)) + path("vi-cross", crosses([cross], 7));
  const far = {away: 35, clear: 9}, of = {lead: "vi-lead-demo", ...shown.length ? far : {}};
  if (middle || !shown.length) names.put("demonstrator", demo, "vi-of-demo", of);
  if (cross) names.put("smallest E without noise", cross, "", far);
  if (middle) names.put("middle of the cloud", middle, "lesson-cloud-words-averaged", far);
  return svg + names.html;
}

/** Images of both arms without noise. @param {Stage} stage @returns {Parameters<typeof smallest>} */
const undisturbed = ({world, session, moment}) =>
  [world, session.settings.transfer, world.look("demonstrator", moment.thetaDemo)];

/** Lines of equal E, undisturbed: near its smallest they are ellipses, equally far from each other.
 * @param {Stage} stage @param {Scales} to */
const rings = (stage, to) => once(stage.world, "rings", () => drawnRings(stage, to), Object.values(to).join());

/** @param {Stage} stage @param {Scales} to */
function drawnRings(stage, {low, high, right, bottom}) {
  const [world, transfer, demo] = undisturbed(stage);
  const part = new Altered(world, {lower: low, upper: high});
  const map = new Landscape(part, Math.min(...low.map((v, k) => high[k] - v)) / DEGREE / STEPS);
  map.evaluate(transfer, demo);
  const {E, axes: [rows, columns]} = map, least = map.minimum?.E ?? 0;
  const most = Math.max(E[Math.floor(rows.length / 2) * columns.length], E[Math.floor(columns.length / 2)]);
  const X = axis(0, columns.length - 1, LEFT, right), Y = axis(0, rows.length - 1, bottom, TOP);
  let lines = "";
  for (let k = 1; k <= RINGS; k++)
    contour(E, rows.length, columns.length, least + (most - least) * (k / RINGS) ** 2, (a, b, c, d) => {
      lines += `M${px(X(a))} ${px(Y(b))}L${px(X(c))} ${px(Y(d))}`;
    });
  return lines;
}

/** Degrees at both axes, and their names. @param {Scales} to @param {string[]} joints */
function ticks({low, high, x, y, right, bottom}, joints) {
  const words = (/** @type {number} */ degrees) => `${fixed(degrees, degrees % 1 ? 1 : 0)}°`;
  const along = nice(low[1], high[1], (right - LEFT) / 48).map(degrees => {
    const at = x(degrees * DEGREE);
    const tick = path("vi-axis", `M${px(at)} ${px(bottom)}v4`) + text(at, bottom + 17, words(degrees), "vi-2nd vi-mid");
    return at > right - 12 ? "" : tick;
  });
  const up = nice(low[0], high[0], (bottom - TOP) / 22).map(degrees => {
    const at = y(degrees * DEGREE);
    return path("vi-axis", `M${LEFT} ${px(at)}h-4`) + text(LEFT - 7, at + 4.5, words(degrees), "vi-2nd vi-end");
  });
  const named = text((LEFT + right) / 2, bottom + 35, joints[1], "vi-2nd vi-mid") + text(4, 16, joints[0], "vi-2nd");
  return [...along, ...up].join("") + named;
}

/** A bracket at the right and one below: a standard deviation to both sides of the middle.
 * @param {number[][]} cloud @param {string} name @param {number} row of the clouds shown @param {Scales} to
 * @param {Names} names */
function spread(cloud, name, row, {x, y, right, bottom}, names) {
  const {mean, off} = meanAndStd(cloud), across = right - 18 - 92 * row, down = bottom - 18 - 24 * row;
  const low = y(mean[0] - off[0]), high = y(mean[0] + off[0]), first = x(mean[1] - off[1]), last = x(mean[1] + off[1]);
  const d = `M${px(across)} ${px(low)}V${px(high)}M${px(across - 5)} ${px(low)}h10M${px(across - 5)} ${px(high)}h10`
    + `M${px(first)} ${px(down)}H${px(last)}M${px(first)} ${px(down - 5)}v10M${px(last)} ${px(down - 5)}v10`;
  const kind = `vi-b vi-halo lesson-cloud-words-${name}`, words = off.map(v => `± ${fixed(v / DEGREE)}°`);
  names.keepBox([across - 70, high - 6, across + 8, low + 6]);
  names.keepBox([first - 6, down - 9, last + 70, down + 9]);
  const said = text(across - 9, (low + high) / 2 + 4.5, words[0], `${kind} vi-end`);
  return path(`lesson-bracket lesson-cloud-${name}`, d) + said + text(last + 9, down + 4.5, words[1], kind);
}

/** @param {Stage} stage @param {Set<string>} layers */
function described(stage, layers) {
  const {names} = stage.world.scene, clouds = cloudsOf(stage);
  const words = [`Where E was smallest under noise: ${names[0]} upwards, ${names[1]} to the right`];
  for (const name of SHOWN) if (layers.has(name) && clouds[name]) {
    const spreads = meanAndStd(clouds[name]).off.map(v => `${fixed(v / DEGREE)}°`);
    words.push(`with ${TITLES[name]} it spreads by ${spreads.join(" and ")}`);
  }
  if (layers.has("bias")) words.push("its middle is near the place where E is smallest without noise, beside the demonstrator");
  return `${words.join("; ")}.`;
}
