/** The map of E over both joints, large: empty, or with its relief, and with the ways that were gone over it.
 * @import {Stage, FigureKind} from "../stage.js"
 * @typedef {{name: string, role: string, postures: number[][], probes: boolean[], best: number}} Way over the map;
 * role: you, learner, opponent or slow; postures: rad; probes: whether each was made to learn from; best: the one
 * with the smallest E, after which it only looked for something lower */
import {stageMap, stageSmallest} from "../maps.js";
import {EnergyMap} from "../../view/map.js";
import {DEGREE, fixed, px} from "../../view/svg.js";
import {circles, crosses, diamonds, dots, path, polyline, text} from "./drawing.js";
import {Names} from "./names.js";

const MOST_DOTS = 60; // motions: of a longer way only the line is drawn
const ORDER = ["slow", "learner", "opponent", "you"]; // in which ways are drawn: where two coincide both are seen
const NOTE = "hollow: a test move", NOTE_WIDE = 122;
const NEAR_EDGE = 110, MARK_WIDE = 104; // units: left of it, the mark's name is at its right; with its name

/** @type {FigureKind} */
export const LANDSCAPE = {
  layers: ["relief", "smallest", "demonstrator", "paths", "others"],
  title: "Map of E for every pose, in px²",
  unit: "rad",
  aspect: 1.7,
  create(box) {
    box.classList.add("bare", "lesson-map");
    const map = new EnergyMap(box);
    let ground = "";
    let over = /** @type {string | null} */ (null);
    return {
      resize() {
        ground = "";
      },
      draw(stage, layers) {
        const {landscape, key} = layers.has("relief") ? stageMap(stage) : {landscape: null, key: ""};
        const {lower, upper, names} = stage.world.scene;
        const now = `${key} ${document.documentElement.dataset.scheme} ${names}`;
        if (now !== ground) {
          map.ground(landscape, {lower, upper, joints: names});
          [ground, over] = [now, null];
        }
        const drawn = marks(map, stage, layers);
        if (drawn === over) return;
        map.moving.innerHTML = over = drawn;
        map.over.setAttribute("aria-label", described(stage, layers));
      },
      place: (_, theta) => /** @type {[number, number]} */ (map.place([...theta]).map(v => v * map.unit)),
      unplace: (_, [x, y]) => /** @type {[number, number]} */ (map.posture(x / map.unit, y / map.unit)),
    };
  },
};

/** The visitor's mark, where it is asked for. @param {Stage} stage */
const markOf = ({step: {ask}, mark}) => ask.kind === "place" && ask.figure === "landscape" ? mark : null;

/** @param {EnergyMap} map @param {Stage} stage @param {Set<string>} layers */
function marks(map, stage, layers) {
  const place = (/** @type {ArrayLike<number>} */ theta) => map.place([theta[0], theta[1]]);
  const lowest = layers.has("smallest") ? stageSmallest(stage) : null, mark = markOf(stage);
  const demo = layers.has("demonstrator") && !stage.truthHidden ? place(stage.moment.thetaDemo) : null;
  const cross = lowest && place(lowest), ways = waysOf(stage, layers), names = new Names(map.plot);
  for (const each of [cross, demo]) if (each) names.keep(each, 9);
  if (mark) takeMark(names, place(mark), stage.isRevealed ? cross : null);
  let below = "", above = "";
  for (const way of ways) {
    const points = way.postures.map(place);
    names.keepLine(points);
    below += drawnWay(points, way);
  }
  if (cross) above += path("lesson-cross-case", crosses([cross], 8)) + path("vi-cross", crosses([cross], 8));
  if (demo) above += path("vi-seen", diamonds([demo], 6.5));
  const now = layers.has("paths") && (turnsOwn(stage) || stage.isShown) ? place(stage.moment.theta) : null;
  if (now) {
    names.keep(now, 9);
    above += `<circle class="vi-now" cx="${px(now[0])}" cy="${px(now[1])}" r="6.5"/>`;
    names.put("now", now, "vi-of-own");
  }
  for (const {name, role, postures, best} of ways)
    names.put(name, place(postures[best]), `lesson-way-${role}-words`);
  if (demo) names.put("demonstrator", demo, "vi-of-demo", {first: [1, 0], lead: "vi-lead-demo"});
  if (cross) names.put("smallest E", cross, "", {first: [-1, 0]});
  if (ways.some(({probes, best}) => probes.slice(0, best + 1).some(Boolean))) above += noted(map.plot, names);
  map.clear(box => names.isFree(box));
  return below + above + names.html;
}

/** Whether sliders turn the learner's arm freely. @param {Stage} stage */
const turnsOwn = ({step: {ask, sliders}, isRevealed}) =>
  isRevealed && ask.kind !== "do" && (sliders ?? []).some(({name}) => name.startsWith("own "));

/** Leave the visitor's mark free, its name, and the pill between it and the truth.
 * @param {Names} names @param {number[]} mark @param {number[] | null} truth */
function takeMark(names, [x, y], truth) {
  names.keep([x, y], 18);
  if (x < NEAR_EDGE) names.keepBox([x, y - 10, x + MARK_WIDE, y + 10]);
  else names.keepBox([x - MARK_WIDE, y - 10, x, y + 10]);
  if (truth) names.keep([(x + truth[0]) / 2, (y + truth[1]) / 2], 16);
}

/** What hollow marks are, in a corner that is free. @param {number[]} plot @param {Names} names */
function noted([left, top, right, bottom], names) {
  for (const y of [bottom, top + 24]) for (const x of [right - NOTE_WIDE, left + 8]) {
    if (!names.isFree([x, y - 21, x + NOTE_WIDE - 6, y - 3])) continue;
    names.keepBox([x, y - 21, x + NOTE_WIDE - 6, y - 3]);
    return text(x, y - 8, NOTE, "vi-2nd vi-halo");
  }
  return "";
}

/** Cased in paper, so that it reads on any shade. @param {number[][]} points @param {Way} way */
function drawnWay(points, {role, best, probes}) {
  const until = points.slice(0, best + 1), line = polyline(until), kind = `lesson-way lesson-way-${role}`;
  const after = path(`${kind} lesson-way-on`, polyline(points.slice(best)));
  const drawn = after + path("lesson-way-case", line) + path(kind, line);
  if (points.length > MOST_DOTS) return drawn;
  return drawn + path(`lesson-way-dots lesson-way-${role}`, dots(until.filter((_, k) => !probes[k])))
    + path(`lesson-way-probes lesson-way-${role}`, circles(until.filter((_, k) => probes[k]), 3.6));
}

/** The visitor's own way and those of servos, up to the motion that is shown. @param {Stage} stage @param {Set<string>} layers */
function waysOf(stage, layers) {
  const ways = /** @type {Way[]} */ ([]);
  if (layers.has("others")) {
    const races = stage.racing, longest = Math.max(1, ...races.map(({race}) => race.postures.length));
    const shown = 1 + stage.played(longest);
    for (const {role, title, race} of races) {
      const until = races.length > 1 ? Math.min(shown, stage.last(race) + 1) : shown; // several race to the goal
      const E = race.E.slice(0, until);
      ways.push({name: races.length === 1 ? "the learner" : title, role: role === "plain" ? "slow" : role,
        postures: race.postures.slice(0, until), probes: race.probes,
        best: E.indexOf(Math.min(...E))});
    }
  }
  if (layers.has("paths") && stage.steps) {
    const postures = stage.motions.slice(0, stage.steps + 1).map(({theta}) => theta);
    ways.push({name: "you", role: "you", postures, probes: postures.map(() => false), best: postures.length - 1});
  }
  return ways.sort((a, b) => ORDER.indexOf(a.role) - ORDER.indexOf(b.role));
}

/** @param {Stage} stage @param {Set<string>} layers */
function described(stage, layers) {
  const {names} = stage.world.scene, words = [`Map of E: ${names[0]} upwards, ${names[1]} to the right`];
  const at = (/** @type {ArrayLike<number>} */ theta) =>
    names.map((name, k) => `${name} ${fixed(theta[k] / DEGREE, 0)}°`).join(", ");
  if (!layers.has("relief")) words.push("it is empty");
  const lowest = layers.has("smallest") ? stageSmallest(stage) : null, mark = markOf(stage);
  if (lowest) words.push(`E is smallest at ${at(lowest)}`);
  if (layers.has("demonstrator") && !stage.truthHidden)
    words.push(`the demonstrator is at ${at(stage.moment.thetaDemo)}`);
  if (layers.has("paths") && (turnsOwn(stage) || stage.isShown)) words.push(`the learner is at ${at(stage.moment.theta)}`);
  if (mark) words.push(`your mark is at ${at(mark)}`);
  for (const {name, postures, best} of waysOf(stage, layers))
    words.push(`the way of ${name} ends at ${at(postures[best])}`);
  return `${words.join("; ")}.`;
}
