/** A servo that learns the images, not E: ŷ(θ) = y_c + J (θ - c), with J by Broyden's updates (1965).
 *
 * One probe of each joint makes a first J. Then the posture with the smallest predicted E inside a trust region is
 * visited. The E measured there sizes the region, and the motion itself improves J. The best posture visited is the
 * centre c. */
import {DEGREE, dot, largest} from "./algebra.js";
import {minimise} from "./minimise.js";
import {conflict as energyOf} from "./transfers.js";

/** @import {Conflict, Observation, Servo, ServoState} from "./servo.js" */
/** @typedef {{displacement: number[], own: Float64Array, seen: Uint8Array}} Visit a posture that was visited, and the
 * images there; points not seen there are as predicted, NaN until they have been seen once
 * @typedef {{J: Float64Array[], last: Visit, taught: number[]}} ImageModel J: of each joint, (4 N) px/rad; taught:
 * how many motions showed a point at both ends
 * @typedef {ServoState & {model: ImageModel, best: Visit, bestE: number | null, radius: number, probes: number[],
 * predicted: number | null}} BroydenState bestE: null where it must be asked for; probes: joints still to probe;
 * predicted: decrease of E of the motion just made, null after a probe */

const PROBE_RAD = 15 * DEGREE;
const FIRST_RADIUS_RAD = 25 * DEGREE, MAX_RADIUS_RAD = 45 * DEGREE, MIN_RADIUS_RAD = 0.02 * DEGREE;
const MIN_STEP_RAD = 0.1 * DEGREE; // a shorter motion is not worth making
const MIN_GAIN_LEFT = 0.01; // share of E that a step cut short by the region must still promise to count as stalled
const SHRINK_BELOW = 0.25, GROW_ABOVE = 0.6; // ratios of actual to predicted decrease
const SOFT_RAD = 0.2 * DEGREE; // motions of this size and below teach less: they are mostly noise
const MANY_POINTS = 12; // that were seen often, so that those seen rarely are not needed

/** @type {Servo<BroydenState>} */
export const broyden = {
  start(seen) {
    const own = seen.own.map((v, i) => seen.seen[i >> 1] ? v : NaN);
    const here = {displacement: seen.displacement, own, seen: seen.seen};
    const model = {J: seen.displacement.map(() => new Float64Array(own.length)), last: here, taught: new Array(own.length / 4).fill(0)};
    return {
      model, best: here, bestE: null, radius: FIRST_RADIUS_RAD, probes: seen.displacement.map((_, k) => k),
      predicted: null, status: "moving", probe: false,
    };
  },

  retarget: state => ({...state, radius: FIRST_RADIUS_RAD, predicted: null, bestE: null, status: "moving"}),

  step(before, seen, conflict) {
    const state = sized(learned(before, seen), seen.E, conflict);
    if (state.probes.length) {
      const [joint, ...probes] = state.probes;
      return [{...state, probes, predicted: null, status: "moving", probe: true}, probeOf(joint, seen)];
    }
    const {model, best, radius} = state;
    const low = best.displacement.map((v, k) => Math.max(seen.lower[k], v - radius));
    const high = best.displacement.map((v, k) => Math.min(seen.upper[k], v + radius));
    const known = onlyTaught(model, best.own);
    let count = 0;
    const found = minimise(thetas => {
      const asked = conflict(thetas.map(theta => moved(known, model.J, theta.map((v, k) => v - best.displacement[k]))));
      count = asked.count;
      return asked.residuals;
    }, e => energyOf(e, count), best.displacement, low, high);
    const predicted = found.startE - found.E, step = found.theta.map((v, k) => v - seen.displacement[k]);
    if (largest(step) < MIN_STEP_RAD) {
      const cutShort = radius < 2 * MIN_STEP_RAD && predicted > MIN_GAIN_LEFT * seen.E; // by the region, not by the model
      return [{...state, predicted: null, status: cutShort ? "no-progress" : "settled", probe: false}, step.map(() => 0)];
    }
    return [{...state, predicted, status: "moving", probe: false}, step];
  },
};

/** One joint turned by 15°, towards where its limits leave more room. @param {number} joint @param {Observation} seen */
function probeOf(joint, {displacement, lower, upper}) {
  const above = upper[joint] - displacement[joint], below = displacement[joint] - lower[joint];
  const step = above >= Math.min(PROBE_RAD, below) ? Math.min(PROBE_RAD, above) : -Math.min(PROBE_RAD, below);
  return displacement.map((_, k) => k === joint ? step : 0);
}

/** Images after a displacement, by the model: own + J · by.
 * @param {Float64Array} own @param {Float64Array[]} J @param {number[]} by */
const moved = (own, J, by) => own.map((v, i) => {
  let sum = 0;
  for (let k = 0; k < by.length; k++) sum += J[k][i] * by[k];
  return v + sum;
});

/** Broyden's update of J from the last motion.
 * @param {BroydenState} state @param {Observation} seen @returns {BroydenState} */
function learned(state, seen) {
  const {J, last, taught} = state.model, by = seen.displacement.map((v, k) => v - last.displacement[k]), length = dot(by, by);
  const expected = moved(last.own, J, by), soft = state.probe ? 0 : SOFT_RAD;
  /** @type {ImageModel} */
  const model = {J, taught, last: {
    displacement: seen.displacement, own: expected.map((v, i) => seen.seen[i >> 1] ? seen.own[i] : v), seen: seen.seen,
  }};
  if (length > 0) {
    const surprise = expected.map((v, i) => seen.seen[i >> 1] && last.seen[i >> 1] ? seen.own[i] - v : 0);
    model.J = J.map((column, k) => column.map((v, i) => v + surprise[i] * by[k] / (length + soft ** 2)));
    model.taught = taught.map((n, i) => n + (seen.seen[2 * i] & seen.seen[2 * i + 1] & last.seen[2 * i] & last.seen[2 * i + 1]));
  }
  const away = state.best.displacement.map((v, k) => v - model.last.displacement[k]);
  const predicted = moved(model.last.own, model.J, away); // completes what the best visit did not show
  const own = state.best.own.map((v, i) => Number.isNaN(v) ? predicted[i] : v);
  return {...state, model, best: {...state.best, own}};
}

/** The better of the best and the last visit, and a radius by how true the prediction was.
 * @param {BroydenState} state @param {number} E @param {Conflict} conflict @returns {BroydenState} */
function sized(state, E, conflict) {
  const here = state.model.last, every = (/** @type {Visit} */ visit) => visit.seen.every(Boolean);
  let {best, bestE, radius} = state;
  if (bestE === null || !(every(here) && every(best))) { // the demonstrator moved, or E was of other points each time
    const {residuals, count} = conflict([best.own, here.own].map(own => onlyTaught(state.model, own)));
    [bestE, E] = residuals.map(e => energyOf(e, count));
  }
  if (state.predicted !== null) {
    const ratio = (bestE - E) / Math.max(state.predicted, 1e-12);
    const step = largest(here.displacement.map((v, k) => v - best.displacement[k]));
    if (ratio < SHRINK_BELOW) radius = Math.max(0.4 * step, MIN_RADIUS_RAD);
    else if (ratio > GROW_ABOVE && step > 0.8 * radius) radius = Math.min(2 * radius, MAX_RADIUS_RAD);
  }
  if (E <= bestE) [best, bestE] = [here, E];
  return {...state, best, bestE, radius};
}

/** Images with NaN for points that fewer motions taught than there are joints, if others were taught by that many.
 * @param {ImageModel} model @param {Float64Array} own */
function onlyTaught({taught, J}, own) {
  const often = [...taught].sort((a, b) => b - a)[Math.min(MANY_POINTS, taught.length) - 1], needed = Math.min(J.length, often);
  return own.map((v, i) => taught[i >> 2] < needed ? NaN : v);
}
