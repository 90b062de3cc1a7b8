/** A motion of the demonstrator's hand that lines follow that were found once: in L, and from the side, where only
 * a viewer can stand.
 * @import {Stage, FigureKind} from "../stage.js" @import {World} from "../../engine/world.js"
 * @typedef {{frozen: number[], postures: number[][]}} Followed rad: the posture in which lines were found, and those
 * by which the learner followed
 * @typedef {{demonstrator: number[][], right: Followed, early: Followed}} CircleRuns rad
 * @typedef {Object} Way of one hand, frame by frame
 * @property {number[][][]} arms px in L, base to hand
 * @property {number[][]} target px in L: where the lines say that the hand should be
 * @property {number[][]} truth px in L: where it would be in the demonstrator's posture
 * @property {number[][][]} side m, the arm from the side, its base at 0
 * @property {number[]} overlapPx from where the lines say, mean of L and R
 * @property {number[]} handMm from the demonstrator's hand, both bases laid over each other
 * @property {number[][]} still px in L: the arm when the lines were found
 * @typedef {{role: string, name: string, path: number[][], arms: number[][][] | null, still?: boolean}} Hand
 * @typedef {{title: string, unit: string, values: [string, number[]][], low: number, high: number}} Curve by role */
import {projectPoint, TRANSFERS} from "../../engine/engine.js";
import {px} from "../../view/svg.js";
import {short} from "../measured.js";
import {once} from "../../view/once.js";
import {
  axis, decades, diamonds, dots, Drawing, fitted, legend, legendHeight, path, polyline, rectangle, text, widthOf,
} from "./drawing.js";

const MARGIN = 18, CURVE_HIGH = 96, LEAST_CURVE = 62, LEAST_PICTURE = 190; // units
const BARS = [1, 2, 5, 10, 20, 50, 100, 200, 500]; // of the scale, in its unit
const ROLES = {right: "learner", early: "opponent"};
const FROZEN = {right: "lines kept when poses agreed", early: "lines kept too early"};

/** @type {FigureKind} */
export const CIRCLE_IN_L = {
  layers: ["still right", "still early", "right", "early", "targets", "truth"],
  title: "**L** left eye",
  aspect: .72,
  create: box => create(box, inImage),
};

/** @type {FigureKind} */
export const CIRCLE_FROM_SIDE = {
  layers: ["circle", "right", "early", "px", "mm"],
  title: "From the side, both arms laid over each other",
  aspect: .72,
  create: box => create(box, fromSide),
};

/** @typedef {{hands: Hand[], curves: Curve[], room: number[][], upwards: boolean, unit: string, perUnit: number}}
 * Shown @param {HTMLElement} box @param {(stage: Stage, layers: Set<string>) => Shown} shownOf */
function create(box, shownOf) {
  const drawing = new Drawing(box, "lesson-circle");
  return {
    resize: () => drawing.measure(),
    draw(/** @type {Stage} */ stage, /** @type {Set<string>} */ layers) {
      const shown = shownOf(stage, layers), {length} = stage.records.circle.demonstrator;
      const frame = stage.isRevealed ? stage.played(length) : length - 1;
      drawing.show(drawn(drawing, shown, frame), described(shown, frame));
    },
  };
}

/** @param {Stage} stage @param {Set<string>} layers @returns {Shown} */
function inImage(stage, layers) {
  const ways = waysOf(stage), hasTargets = layers.has("targets");
  const hands = /** @type {Hand[]} */ ([]);
  if (layers.has("truth") && !stage.truthHidden)
    hands.push({role: "demonstrator", name: "the true path", path: ways.right.truth, arms: null});
  for (const which of /** @type {const} */ (["right", "early"])) {
    const {arms, target, still} = ways[which], role = ROLES[which], name = hasTargets ? "its own hand" : FROZEN[which];
    if (layers.has(which) && hasTargets)
      hands.push({role: "recovered", name: "where the lines say it should be", path: target, arms: null});
    if (layers.has(which)) hands.push({role, name, path: arms.map(last), arms});
    else if (layers.has(`still ${which}`)) hands.push({role, name, path: [], arms: [still], still: true});
  }
  const room = [ways.right, ways.early].flatMap(({truth, target, arms}) => [...truth, ...target, ...arms.flat()]);
  return {hands, curves: [], room, upwards: false, unit: "px", perUnit: 1};
}

/** @param {Stage} stage @param {Set<string>} layers @returns {Shown} */
function fromSide(stage, layers) {
  const ways = waysOf(stage), runs = /** @type {const} */ (["right", "early"]).filter(which => layers.has(which));
  const demo = demonstratorFromSide(stage);
  const hands = /** @type {Hand[]} */ ([]);
  if (layers.has("circle"))
    hands.push({role: "demonstrator", name: "the demonstrator", path: demo.map(last), arms: demo});
  for (const which of runs) {
    const {side} = ways[which];
    hands.push({role: ROLES[which], name: FROZEN[which], path: side.map(last), arms: side});
  }
  const of = runs.length ? runs : /** @type {const} */ (["early"]);
  const curves = /** @type {Curve[]} */ ([]);
  if (layers.has("px")) curves.push({
    title: "Apart in its picture", unit: "px, from where its lines say", low: .1, high: 10,
    values: of.map(which => [ROLES[which], ways[which].overlapPx]),
  });
  if (layers.has("mm") && !stage.truthHidden) curves.push({
    title: "Hands apart in space", unit: "mm, hidden from the learner", low: 1, high: 1000,
    values: of.map(which => [ROLES[which], ways[which].handMm]),
  });
  const room = [...demo, ...ways.right.side, ...ways.early.side].flat();
  return {hands, curves, room, upwards: true, unit: "mm", perUnit: 1000};
}

/** @template T @param {T[]} of */
const last = of => of[of.length - 1];

/** What both learners do. @param {Stage} stage @returns {{right: Way, early: Way}} */
export function waysOf(stage) {
  /** @type {CircleRuns} */
  const record = stage.records.circle;
  return once(record, "ways", () => ({right: wayOf(stage, record, record.right), early: wayOf(stage, record, record.early)}));
}

/** @param {Stage} stage @param {CircleRuns} record @param {Followed} followed @returns {Way} */
function wayOf({world, session, moment}, {demonstrator}, {frozen, postures}) {
  const origins = (/** @type {"learner" | "demonstrator"} */ who, /** @type {number[]} */ theta) =>
    world.arms[who].linkFrames(theta).map(T => [T[3], T[7], T[11]]);
  const inImages = (/** @type {"learner" | "demonstrator"} */ who, /** @type {number[]} */ theta) =>
    world.pairs[who].map(camera => origins(who, theta).map(p => [...projectPoint(camera, p)].slice(0, 2)));
  const seen = world.look("demonstrator", moment.thetaDemo).images, own = world.look("learner", frozen).images;
  const lines = TRANSFERS[session.settings.transfer].fit(seen, own);
  const hands = demonstrator.map(theta => inImages("demonstrator", theta).flatMap(last));
  const targets = lines.recover(Float64Array.from(hands.flat()));
  const arms = postures.map(theta => inImages("learner", theta));
  const [side, demo] = [postures, demonstrator].map(of => of.map(theta => fromBase(world, theta)));
  return {
    arms: arms.map(([left]) => left),
    target: hands.map((_, k) => [targets[4 * k], targets[4 * k + 1]]),
    truth: demonstrator.map(theta => last(inImages("learner", theta)[0])),
    side: side.map(upright),
    overlapPx: arms.map((both, k) => both.reduce((sum, arm, eye) =>
      sum + Math.hypot(last(arm)[0] - targets[4 * k + 2 * eye], last(arm)[1] - targets[4 * k + 2 * eye + 1]) / 2, 0)),
    handMm: side.map((arm, k) => 1000 * Math.hypot(...last(demo[k]).map((v, i) => v - last(arm)[i]))),
    still: inImages("learner", frozen)[0],
  };
}

/** Origins of the links, m from the base. @param {World} world @param {number[]} theta */
function fromBase(world, theta) {
  const arm = world.arms.learner, base = arm.T_world_base;
  return arm.linkFrames(theta).map(T => {
    const p = [T[3] - base[3], T[7] - base[7], T[11] - base[11]];
    return [0, 1, 2].map(k => base[k] * p[0] + base[k + 4] * p[1] + base[k + 8] * p[2]);
  });
}

/** Forward and up: the plane in which both joints turn the arm. @param {number[][]} points */
const upright = points => points.map(([x, , z]) => [x, z]);

/** @param {Stage} stage */
const demonstratorFromSide = ({world, records}) =>
  /** @type {number[][]} */ (records.circle.demonstrator).map(theta => upright(fromBase(world, theta)));

/** @param {Drawing} drawing @param {Shown} shown @param {number} frame */
function drawn({width, height}, {hands, curves, room, upwards, unit, perUnit}, frame) {
  const rows = hands.map(rowOf), foot = legendHeight(rows, width) + 10;
  const share = (height - foot - LEAST_PICTURE) / Math.max(curves.length, 1);
  const each = Math.max(LEAST_CURVE, Math.min(CURVE_HIGH, share));
  const bottom = height - foot - curves.length * each, turned = upwards ? -1 : 1;
  const flip = (/** @type {number[]} */ [x, y]) => [x, turned * y];
  const {scale, place: at} = fitted(room.map(flip), [MARGIN, MARGIN, width - MARGIN, bottom - MARGIN]);
  const place = (/** @type {number[]} */ p) => at(flip(p));
  let svg = rectangle("vi-plane", .5, .5, width - 1, bottom - 1, 5);
  for (const {role, arms} of hands) if (arms) {
    const bones = polyline(arms[Math.min(frame, arms.length - 1)].map(place));
    svg += `<g class="lesson-hand-${role}">${path("lesson-limb", bones)}${path("lesson-limb-line", bones)}</g>`;
  }
  for (const {role, path: way, still} of hands) if (!still) {
    const points = way.slice(0, frame + 1).map(place), end = points.slice(-1);
    const isArm = role === "learner" || role === "opponent";
    const mark = isArm ? path("lesson-hand-dot", dots(end)) : path("lesson-hand-mark", diamonds(end, 5));
    svg += `<g class="lesson-hand-${role}">${path("lesson-hand-line", polyline(points))}${mark}</g>`;
  }
  const size = BARS.filter(bar => bar * scale / perUnit < width / 3).pop() ?? 1, long = size * scale / perUnit;
  const isTaken = room.map(place).some(p => p[0] > width - long - 24 && p[1] > bottom - 34);
  const x = isTaken ? 12 : width - 12 - long;
  svg += path("vi-lead", `M${px(x)} ${px(bottom - 10)}h${px(long)}`);
  svg += text(x, bottom - 15, `${size} ${unit}`, "vi-2nd vi-halo");
  svg += legend(rows, 2, bottom + 14, width).drawn;
  return svg + curves.map((curve, k) => drawnCurve(curve, bottom + foot + k * each, each, width, frame)).join("");
}

/** What a line is. @param {Hand} hand @returns {[string, string, string]} */
const rowOf = ({role, name, still}) => {
  const sample = still ? path("lesson-limb", "M6 0h18") : path("lesson-hand-line", "M0 0h30");
  return [`<g class="lesson-hand-${role}">${sample}</g>`, name, `vi-b lesson-hand-words-${role}`];
};

/** Over the way, on a logarithmic scale.
 * @param {Curve} curve @param {number} top @param {number} high @param {number} width @param {number} frame */
function drawnCurve({title, unit, values, low, high: most}, top, high, width, frame) {
  const all = values.flatMap(([, of]) => of).map(v => Math.max(v, low / 100)), left = 44, right = width - 8;
  const {from, to, ticks} = decades([low, most, ...all], Math.floor((high - 30) / 16));
  const y = axis(from, to, top + high - 6, top + 24, true);
  const x = axis(0, Math.max(values[0][1].length - 1, 1), left, right);
  let svg = text(0, top + 14, title, "vi-b") + text(widthOf(title, true) + 8, top + 14, unit, "vi-2nd");
  svg += path("vi-rule", ticks.map(v => `M${left} ${px(y(v))}H${px(right)}`).join(""));
  svg += ticks.map(v => text(left - 6, y(v) + 4.5, String(v), "vi-2nd vi-end")).join("");
  for (const [role, of] of values) {
    const points = of.slice(0, frame + 1).map((v, k) => [x(k), y(Math.max(v, from))]);
    const line = path("lesson-hand-line", polyline(points)), end = path("lesson-hand-dot", dots(points.slice(-1)));
    svg += `<g class="lesson-hand-${role}">${line}${end}</g>`;
  }
  return svg;
}

/** @param {Shown} shown @param {number} frame */
function described({hands, curves}, frame) {
  const words = hands.map(({name, still}) => `${still ? "the arm when it kept its lines" : "a path"}: ${name}`);
  for (const {title, unit, values} of curves) {
    const now = values.map(([, of]) => short(of[Math.min(frame, of.length - 1)]));
    words.push(`${title}: ${now.join(" and ")} ${unit.split(",")[0]}`);
  }
  return `${words.join("; ")}.`;
}
