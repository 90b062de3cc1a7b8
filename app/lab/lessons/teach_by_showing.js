/** Teaching by showing: an arm goes to where its image points stood in a picture that it was shown.
 *
 * The servo knows how its picture reacts to its joints, the image Jacobian J, and goes by u = -λ J⁺ (y - y*):
 * the step for which J promises the goal, times the gain λ (Hutchinson, Hager & Corke 1996). Broyden's update (1965)
 * corrects J by what each step really did.
 * @import {World} from "../engine/world.js"
 * @typedef {Object} Task
 * @property {number[]} start rad
 * @property {number[]} goal the posture whose picture was shown, rad
 * @property {number} gain λ
 * @property {boolean} update whether Broyden's update corrects J
 * @property {number[]} coordinates which of the (4 N) image coordinates the servo sees
 * @property {number} probeRad by how much each joint is turned to learn the first J
 * @property {number} [rollRad] by how much the camera is turned about its axis after J was learned
 * @property {number} [steps] how many are made
 * @typedef {{postures: number[][], images: Float64Array[], goal: Float64Array, errors: number[]}} Run postures: rad,
 * of the start and after each step; images: (4 N) px at each of them, in the turned camera; goal: (4 N) px; errors:
 * rms px from the goal, over the points that the servo sees */
import {clamp, dot, leastSquares} from "../engine/algebra.js";

const STEPS = 60;
const MIN_MOTION_RAD = 1e-9; // a shorter motion says nothing about J

/** Image coordinates in a camera that is turned about its axis: the picture turns the other way round.
 * @param {Float64Array} images (4 N) px @param {number} rollRad of the camera
 * @param {number[]} centre px, of the picture */
export function rolled(images, rollRad, [cx, cy]) {
  const c = Math.cos(-rollRad), s = Math.sin(-rollRad), found = new Float64Array(images.length);
  for (let i = 0; i < images.length; i += 2) {
    const x = images[i] - cx, y = images[i + 1] - cy;
    found[i] = cx + c * x - s * y;
    found[i + 1] = cy + s * x + c * y;
  }
  return found;
}

/** Which of the image coordinates are in L and R, or in L alone. @param {number} points @param {boolean} both */
export const coordinatesOf = (points, both) =>
  Array.from({length: 4 * points}, (_, k) => k).filter(k => both || (k & 3) < 2);

/** Go to the goal. J is learned before the camera is turned, from one probe of each joint at the start.
 * @param {World} world @param {Task} task @returns {Run} */
export function teachByShowing(world, {start, goal, gain, update, coordinates, probeRad, rollRad = 0, steps = STEPS}) {
  const {scene} = world, camera = world.pairs.learner[0], centre = camera.principal, count = start.length;
  const see = (/** @type {number[]} */ theta, roll = rollRad) =>
    rolled(world.look("learner", theta).images, roll, centre);
  const pick = (/** @type {Float64Array} */ images) => Float64Array.from(coordinates, k => images[k]);
  const rest = pick(see(start, 0));
  let J = start.map((_, joint) => {
    const probed = pick(see(start.map((v, k) => k === joint ? v + probeRad : v), 0));
    return probed.map((v, i) => (v - rest[i]) / probeRad);
  });
  const goalImages = see(goal), target = pick(goalImages);
  const postures = [start], images = [see(start)];
  const rms = (/** @type {Float64Array} */ e) => Math.sqrt(dot(e, e) / (e.length / 2));
  let y = pick(images[0]);
  const errors = [rms(y.map((v, i) => v - target[i]))];
  for (let step = 0; step < steps; step++) {
    const A = new Float64Array(count * y.length), e = y.map((v, i) => gain * (target[i] - v));
    J.forEach((column, k) => column.forEach((v, i) => { A[count * i + k] = v; }));
    const u = leastSquares(A, e, count, 1), theta = postures[step];
    const next = theta.map((v, k) => clamp(v + u[k], scene.lower[k], scene.upper[k]));
    const moved = next.map((v, k) => v - theta[k]), seen = see(next), after = pick(seen);
    if (update && Math.hypot(...moved) > MIN_MOTION_RAD) J = updated(J, moved, after.map((v, i) => v - y[i]));
    postures.push(next);
    images.push(seen);
    errors.push(rms(after.map((v, i) => v - target[i])));
    y = after;
  }
  return {postures, images, goal: goalImages, errors};
}

/** After how many steps the goal was first reached, NaN for never. @param {Run} run @param {number} belowPx */
export function stepsTo({errors}, belowPx) {
  const found = errors.findIndex(error => error < belowPx);
  return found < 0 ? NaN : found;
}

/** Broyden's update: J moves the least that explains the motion.
 * @param {Float64Array[]} J one column for each joint, px/rad @param {number[]} moved rad
 * @param {Float64Array} change px */
export function updated(J, moved, change) {
  const square = dot(moved, moved);
  const surprise = change.map((v, i) => v - J.reduce((sum, column, k) => sum + column[i] * moved[k], 0));
  return J.map((column, k) => column.map((v, i) => v + surprise[i] * moved[k] / square));
}
