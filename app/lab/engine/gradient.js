/** The paper's servo law, Section 4: E descends along a gradient that is learned from the learner's own motions.
 *
 * ΔE = Ĵu is fitted by recursive least squares with forgetting, and u = -K Ĵᵀ E is Eq. (13), with the transpose that
 * its print lacks. The constants of Section 5.3 are read in degrees and px². The paper gives no first covariance, no
 * bound of the step and no excitation. Without excitation the covariance grows along the directions in which the arm
 * does not move (windup), and amplifies rounding errors: after some 130 motions no two programs agree any more. */
import {clamp, DEGREE, dot} from "./algebra.js";
import {Generator} from "./random.js";

/** @import {Servo, ServoState, ServoStatus} from "./servo.js" */
/** @typedef {{gain: number, forgetting: number, jacobian: number[], covariance: number, maxStepDeg: number,
 * ditherDeg: number, seed: number}} Constants gain: K = gain I, degrees/px² per px²/degree; forgetting: ρ; jacobian:
 * Ĵ_0, px²/degree, repeated for more joints; covariance: P_0 = covariance I; ditherDeg: excitation of each step
 * @typedef {ServoState & {jacobian: number[], covariance: number[][], displacement: number[], E: number, bestE:
 * number, sinceBest: number}} GradientState */

const MAX_MOTIONS_WITHOUT_PROGRESS = 30, PROGRESS = 0.99; // E must fall to this share of its least

/** Sec. 5.3 and Eq. (14). P_0 is not given there. @type {Constants} */
const PAPER = {gain: 0.5e-2, forgetting: 0.95, jacobian: [-1, 1], covariance: 1, maxStepDeg: Infinity, ditherDeg: 0, seed: 0};
/** Values with which it mostly arrives. @type {Constants} */
const RETUNED = {...PAPER, gain: 0.5, covariance: 1e3, maxStepDeg: 2, ditherDeg: 0.2};

/** @param {Constants} constants @returns {Servo<GradientState>} */
const gradientLaw = constants => ({
  start({displacement, E}) {
    const jacobian = displacement.map((_, k) => constants.jacobian[k % constants.jacobian.length]);
    const covariance = displacement.map((_, i) => displacement.map((_, j) => i === j ? constants.covariance : 0));
    return {jacobian, covariance, displacement, E, bestE: E, sinceBest: 0, status: "moving", probe: false};
  },

  retarget: (state, {displacement, E}) => ({...state, displacement, E, bestE: Infinity, sinceBest: 0, status: "moving"}),

  step(state, {displacement, E, lower, upper, motion}) {
    const moved = displacement.map((v, k) => (v - state.displacement[k]) / DEGREE);
    const {jacobian, covariance} = learned(state, moved, E - state.E, constants.forgetting);
    let u = jacobian.map(v => -constants.gain * v * E); // Eq. (13)
    const length = Math.hypot(...u);
    if (length > 0) u = u.map(v => v * Math.min(1, constants.maxStepDeg / length));
    const random = new Generator([constants.seed, motion]);
    const low = lower.map((v, k) => v - displacement[k]), high = upper.map((v, k) => v - displacement[k]);
    const step = u.map((v, k) => {
      const inside = clamp(v * DEGREE, low[k], high[k]); // the dither comes after, to excite a joint at its limit
      return constants.ditherDeg ? clamp(inside + constants.ditherDeg * random.normal() * DEGREE, low[k], high[k]) : inside;
    });
    const progress = E < PROGRESS * state.bestE, sinceBest = progress ? 0 : state.sinceBest + 1;
    /** @type {ServoStatus} */
    const status = sinceBest >= MAX_MOTIONS_WITHOUT_PROGRESS ? "no-progress" : "moving";
    return [{jacobian, covariance, displacement, E, bestE: progress ? E : state.bestE, sinceBest, status, probe: false}, step];
  },
});

/** Weighted recursive least squares. @param {GradientState} state @param {number[]} u degrees @param {number} dE px² @param {number} forgetting */
function learned({jacobian, covariance}, u, dE, forgetting) {
  if (u.every(v => v === 0)) return {jacobian, covariance};
  const Pu = covariance.map(row => dot(row, u)), weight = forgetting + dot(u, Pu), surprise = dE - dot(jacobian, u);
  return {
    jacobian: jacobian.map((v, k) => v + surprise * Pu[k] / weight),
    covariance: covariance.map((row, i) => row.map((v, j) => (v - Pu[i] * Pu[j] / weight) / forgetting)),
  };
}

export const paperGradient = gradientLaw(PAPER);
export const retunedGradient = gradientLaw(RETUNED);
