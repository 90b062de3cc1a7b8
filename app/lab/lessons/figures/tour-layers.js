/** Layers of the four images for the first lessons: pencils of lines by hand, the ghost with its lines and the way to
 * it, and goals of single points.
 * @import {Stage} from "../stage.js" @import {Frame, Layer} from "./view-layers.js" */
import {pencilOf} from "../measures_ray.js";
import {BASE_POINT, HAND_POINT} from "../measures_tour.js";
import {arrows, circles, diamonds, path, polyline, widthOf} from "./drawing.js";
import {Names} from "./names.js";
import {arm, arrow, lineThrough, mark, ofOwn, pointsIn, residuals, rings} from "./view-layers.js";

const LITTLE = 3; // drawing units of an arrow that is not drawn
const NUMBER = 13, LINE_NAME = 14, MARK_WIDE = 90; // drawing units; MARK_WIDE: of a mark with its name

/** Names that keep clear of the arm, its points and its arrows. @param {Frame} frame @param {Stage} stage */
function namesOver(frame, stage) {
  const {moment, world} = stage, names = new Names([0, 0, frame.width, frame.height]), {layers} = frame;
  const bones = (/** @type {number[]} */ theta, /** @type {string} */ name, /** @type {number} */ radius) => {
    names.keepLine(frame.outlines.of(world, "learner", theta, name)[frame.side].bones.map(frame.at), radius);
  };
  bones(moment.theta, "own", 9);
  if (layers.has("ghost")) bones(moment.thetaDemo, "ghost", 9);
  for (const [found, own] of residuals(frame, stage)) {
    names.keep(own, 5);
    if (layers.has("recovered points")) names.keep(found, 6);
    if (layers.has("arrows")) names.keepLine([found, own], 3);
  }
  const lines = [["line from l", 0, moment], ["line from r", 1, moment]];
  for (const [layer, eye] of lines) if (layers.has(String(layer))) {
    const line = stage.line(Number(eye), frame.side);
    if (line) names.keepLine(frame.ends(line));
  }
  return names;
}

/** The ways of all points to the ghost. @param {Frame} frame @param {Stage} stage */
function ways(frame, stage) {
  const {moment, world} = stage, goal = world.look("learner", moment.thetaDemo).images;
  return moment.usable.map(i => ({i, from: frame.of(moment.views.own, i), to: frame.of(goal, i)}));
}

const SHARES = [[.8, .88, .72, .62, .12, .2, .5], [.2, .12, .28, .88, .8, .7, .36]]; // of a line's way, where its name may stand
const CLEAR = 60; // drawing units: a name that is this far from all points is free

/** Where the name of a line stands: far from all points, and from the other line's name.
 * @param {Frame} frame @param {Stage} stage @param {number} eye
 * @returns {{share: number, at: number[], words: string} | null} null without a line */
function nameOfLine(frame, stage, eye) {
  const line = frame.isDemo ? null : stage.line(eye, frame.side), ends = line ? frame.ends(line) : [];
  if (!ends.length) return null;
  const other = eye && frame.layers.has("line from l") ? nameOfLine(frame, stage, 0) : null;
  const points = [...residuals(frame, stage).flat(), ...other ? [other.at] : []];
  const places = SHARES[eye]
    .map(share => ({share, at: [0, 1].map(k => ends[0][k] + share * (ends[1][k] - ends[0][k]))}));
  const room = (/** @type {{at: number[]}} */ {at: [x, y]}) =>
    Math.min(CLEAR, ...points.map(p => Math.hypot(p[0] - x, p[1] - y)));
  const words = `line from ${"lr"[eye]}`, whole = places.filter(({at}) => fits(frame, at, words, other?.at));
  const best = (whole.length ? whole : places).reduce((a, b) => room(b) > room(a) + 6 ? b : a);
  return {...best, words: whole.length ? words : "lr"[eye]};
}

/** Whether words may stand there at any angle.
 * @param {Frame} frame @param {number[]} at @param {string} words
 * @param {number[]} [other] where words of that length stand already */
function fits({width, height}, [x, y], words, other) {
  const half = widthOf(words, true, LINE_NAME) / 2 + LINE_NAME;
  return Math.min(x, y, width - x, height - y) > half && !(other && Math.hypot(x - other[0], y - other[1]) < 2 * half);
}

/** @param {number} eye @param {string} kind @returns {Layer} */
const lineFrom = (eye, kind) => (frame, stage) => {
  const name = nameOfLine(frame, stage, eye);
  return name ? lineThrough(frame, stage.line(eye, frame.side), kind, name.words, name.share) : "";
};

/** Layers beneath the arm's points and arrows. @type {Record<string, Layer>} */
export const TOUR_LAYERS_BELOW = {
  "ghost": (frame, stage) => {
    const {moment, truthHidden, world} = stage;
    if (frame.isDemo || truthHidden) return "";
    const outline = frame.outlines.of(world, "learner", moment.thetaDemo, "ghost")[frame.side];
    const names = namesOver(frame, stage);
    const hand = outline.hulls[outline.hulls.length - 1].map(frame.at);
    const own = frame.outlines.of(world, "learner", moment.theta, "own")[frame.side];
    const off = (/** @type {number[]} */ p) =>
      Math.min(...own.bones.map(frame.at).map(q => Math.hypot(p[0] - q[0], p[1] - q[1])));
    const tip = hand.reduce((a, b) => off(b) > off(a) ? b : a);
    outline.hulls.flat().map(frame.at).forEach(p => names.keep(p, 6));
    if (Math.hypot(...moment.theta.map((v, k) => v - moment.thetaDemo[k])) > .05)
      names.put("ghost", tip, "vi-2nd", {away: 9, first: [0, 1]});
    return arm(outline, frame, "vi-goal", "vi-goal-bone") + rings(pointsIn(frame, stage, moment.thetaDemo), 4.4, "vi-goal-ring")
      + names.html;
  },
  "ghost lines": (frame, stage) => {
    if (frame.isDemo || stage.truthHidden) return "";
    const ghost = stage.ghost(), lines = [0, 1].map(eye => stage.line(eye, frame.side, ghost));
    const at = frame.of(stage.world.look("learner", stage.moment.thetaDemo).images, stage.chosen);
    return lines.map((line, eye) => lineThrough(frame, line, `draw-ghost-line${eye ? " vi-from-right" : ""}`)).join("")
      + rings([at], 6, "vi-goal-ring");
  },
  "pencil": (frame, stage) => {
    const found = pencilOf(stage), lines = frame.isDemo ? found.first : found.second;
    return lines.map(line => lineThrough(frame, line, "draw-line")).join("");
  },
  "line from l": lineFrom(0, "vi-line vi-line-large"),
  "line from r": lineFrom(1, "vi-line vi-line-large vi-from-right"),
  "goal": ofOwn((frame, stage) => {
    const goal = pointsIn(frame, stage, stage.moment.thetaDemo), ringed = goal[frame.shown.indexOf(stage.chosen)];
    return rings(goal, 5, "draw-goal") + rings(ringed ? [ringed] : [], 12, "draw-goal draw-goal-ringed");
  }),
  "predicted": ofOwn((frame, {rounds}) =>
    path("draw-went", polyline([...rounds.slice(0, 1).map(({from}) => from), ...rounds.map(({to}) => to)].map(frame.at)))),
};

/** Layers over them. @type {Record<string, Layer>} */
export const TOUR_LAYERS_ABOVE = {
  "needed displacement": (frame, stage) => {
    if (frame.isDemo || stage.truthHidden) return "";
    const all = ways(frame, stage), names = namesOver(frame, stage);
    all.forEach(({from, to}) => names.keepLine([from, to], 4));
    for (const {i, from} of all) if (i === HAND_POINT || i === BASE_POINT)
      names.put(i === HAND_POINT ? "hand" : "base", from, "vi-of-E", {away: 10});
    const drawn = all.map(({from, to}) => [from, to]).filter(([from, to]) => Math.hypot(from[0] - to[0], from[1] - to[1]) > LITTLE);
    return arrows(drawn, 9, "draw-way", "draw-way-tip") + names.html;
  },
  "left over": ofOwn((frame, stage) => {
    const {second, left} = pencilOf(stage), {images} = frame;
    const ends = second.map(({a, b}, i) => {
      const p = [images[4 * i + 2 * frame.side], images[4 * i + 2 * frame.side + 1]];
      return /** @type {[number[], number[]]} */ ([frame.at(p), frame.at([p[0] - left[i] * a, p[1] - left[i] * b])]);
    });
    return arrows(ends);
  }),
  "five points": (frame, stage) => {
    const names = new Names([0, 0, frame.width, frame.height]);
    const found = frame.layers.has("pencil") ? pencilOf(stage) : null;
    const places = frame.shown.map(i => frame.of(frame.images, i));
    places.forEach(p => names.keep(p, 7));
    for (const line of found ? frame.isDemo ? found.first : found.second : []) names.keepLine(frame.ends(line));
    const marks = frame.isDemo ? diamonds(places, 5) : circles(places, 4.6);
    places.forEach((p, k) => names.put(String(frame.shown[k] + 1), p, frame.isDemo ? "vi-of-demo" : "vi-of-own",
      {size: NUMBER, away: 10}));
    return `<path class="${frame.isDemo ? "vi-seen" : "draw-own-dot"}" d="${marks}"/>${names.html}`;
  },
  "chosen": (frame, stage) => {
    const {images, isDemo, shown} = frame, {chosen} = stage;
    if (!shown.includes(chosen)) return "";
    const at = [frame.of(images, chosen)];
    return (isDemo ? path("vi-seen", diamonds(at, 5.4)) : path("draw-own-dot", circles(at, 5))) + rings(at, 11, "vi-ring");
  },
  "numbers": (frame, stage) => {
    const {usable, views} = stage.moment, names = namesOver(frame, stage);
    usable.forEach(i => names.put(String(i + 1), frame.of(views.own, i), "vi-of-own", {size: NUMBER, away: 8}));
    return names.html;
  },
  "crossing": (frame, stage) => {
    const {chosen, moment, mark} = stage, found = stage.recovered();
    if (frame.isDemo || !moment.usable.includes(chosen)) return "";
    const at = frame.of(found, chosen), names = namesOver(frame, stage), [x, y] = at;
    names.keep(at, 10);
    if (mark && stage.step.ask.figure === frame.name) {
      const own = frame.at(mark);
      names.keep(own, 20);
      names.keepLine([own, at], 16);
      names.keepBox([own[0] - MARK_WIDE, own[1] - 12, own[0] + MARK_WIDE, own[1] + 12]);
    }
    const words = frame.width > 230 ? "where the lines cross" : "crossing";
    if (x > 0 && y > 0 && x < frame.width && y < frame.height) names.put(words, at, "vi-of-found", {away: 13});
    return path("vi-found", diamonds([at], 6)) + rings([at], 11, "vi-ring") + names.html;
  },
};

/** What their marks mean. @type {Record<string, string>} */
export const TOUR_LEGEND = {
  "needed displacement":
    `${arrow("draw-way", "draw-way-tip")}the way to the ghost, which the learner cannot see`,
  "left over": `${arrow("vi-e", "vi-tip")}how far a point is from its line`,
  "goal": `${mark(`<path class="draw-goal" d="${circles([[0, 0]], 4.5)}"/>`)}where a dot should go`,
};
