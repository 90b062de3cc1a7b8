/** Measures of the lesson on rays: how far off a ray a click is, how lines run, and what matched points leave over.
 * @import {Stage, Measure} from "./stage.js" */
import {symmetricEigen} from "../engine/algebra.js";
import {DEGREE, World} from "../engine/engine.js";
import {placed, measured} from "./measured.js";
import {angleBetween, camerasOf, epipole, LAST_SHARE, markOf, marksOf, movedInPicture1, onRay, pencil, rayLine,
  seenFromOutside, targetOf, twoCameras} from "./rays.js";
import {projectPoint} from "../engine/camera.js";

const DIFFERENT_DEG = [25, -45]; // a posture that is not the demonstrator's, as in the tour
const RAY_FROM = 0.02; // share of the mark's depth, at which the ray begins for a click

/** Points of l and their matches in L, px. @param {World} world @param {number[]} demonstrator @param {number[]} own */
function matches(world, demonstrator, own) {
  const {images: demo} = world.look("demonstrator", demonstrator), {images} = world.look("learner", own);
  return world.body.map((_, i) => [[demo[4 * i], demo[4 * i + 1]], [images[4 * i], images[4 * i + 1]]]);
}

/** The pencils of a stage's two sliders: lines in l, lines in L, and the residual. @param {Stage} stage */
export function pencilOf({world, moment, sliders}) {
  const pairs = matches(world, moment.thetaDemo, moment.theta);
  const angle = (/** @type {string} */ name) => (sliders.get(name) ?? 0) * DEGREE;
  return pencil(pairs.map(([p]) => p), pairs.map(([, q]) => q), angle("lines in l"), angle("lines in L"));
}

/** The largest distance of a point from its line in L, if the lines are fitted to the other four.
 * @param {number[][][]} pairs five matches */
export function fifthLeftOut(pairs) {
  return Math.max(...pairs.map((_, left) => {
    const rows = pairs.map(pair => pair.flat()), used = rows.filter((_, i) => i !== left);
    const mean = [0, 1, 2, 3].map(k => used.reduce((sum, row) => sum + row[k], 0) / used.length);
    const W = new Float64Array(16);
    for (const row of used) for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++)
      W[4 * i + j] += (row[i] - mean[i]) * (row[j] - mean[j]);
    const f = symmetricEigen(W, 4).vectors[0]; // Eq. (2), of four points: their smallest eigenvalue is 0
    return Math.abs(rows[left].reduce((sum, v, k) => sum + f[k] * (v - mean[k]), 0)) / Math.hypot(f[2], f[3]);
  }));
}

/** Five matches of an arm in two poses. @param {Stage} stage @param {number[]} own rad */
const fiveMatches = ({scene, moment}, own) =>
  matches(new World(scene, 5), moment.thetaDemo, own);

/** @type {Record<string, Measure>} */
export const RAY_MEASURES = {
  "px moved in picture 1": ({world, mark}) => measured(mark ? movedInPicture1(world, mark) : NaN, " px", 0),
  "the ray, from outside": ({world}) => {
    const [camera] = twoCameras(world), mark = markOf(world);
    return placed([RAY_FROM, LAST_SHARE].map(share => seenFromOutside(onRay(camera, mark, share))));
  },
  "the mark, from outside": ({world}) => placed(seenFromOutside(markOf(world))),
  "angle between the lines": stage => {
    const [first, second] = camerasOf(stage), lines = marksOf(stage).map(p => rayLine(second, first, p));
    const angles = lines.flatMap((line, k) => lines.slice(k + 1).map(other => angleBetween(line, other)));
    return measured(Math.max(...angles) / DEGREE, "°", 1);
  },
  "px to the epipole": stage => {
    const [first, second] = camerasOf(stage), [x, y] = epipole(second, first);
    const [a, b] = projectPoint(second, targetOf(stage));
    return measured(Math.hypot(x - a, y - b), " px", 0);
  },
  "px left over": stage => measured(pencilOf(stage).rms, " px"),
  "fifth left out, alike": stage => measured(fifthLeftOut(fiveMatches(stage, stage.moment.thetaDemo)), " px", 1),
  "fifth left out, different": stage =>
    measured(fifthLeftOut(fiveMatches(stage, DIFFERENT_DEG.map(v => v * DEGREE))), " px", 0),
  "px from the first line": stage => {
    const line = stage.line(0), {mark} = stage;
    return measured(mark && line ? Math.abs(line.a * mark[0] + line.b * mark[1] + line.c) : NaN, " px", 1);
  },
};
