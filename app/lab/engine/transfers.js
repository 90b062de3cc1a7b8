/** Transfers: from the demonstrator's points in [l], [r] to where they would be in the learner's own views [L], [R], if
 * both arms were in the same pose. And what the learner makes of them: residuals, and the conflict E.
 * @typedef {{recover: (images: Float64Array) => Float64Array, condition: number}} Fitted a transfer that was fitted
 * to matched points; recover: (4 M) px in [l], [r] → (4 M) px in [L], [R]; condition: how far its linear system
 * amplifies errors
 * @typedef {{own: Float64Array, scatters: Float64Array}} Grid centred own images of many postures, (4 N) px each,
 * and their scatter matrices, 4 x 4 each
 * @typedef {{fit: (demo: Float64Array, own: Float64Array) => Fitted, energies: (demo: Float64Array) => (grid: Grid,
 * posture: number) => number}} Transfer fit: of points that all four views show, (4 N) px each; energies: E of every
 * posture of a grid */
import {epipolar} from "./epipolar.js";
import {linear} from "./linear.js";
import {projective} from "./projective.js";

/** @type {Record<string, Transfer>} */
export const TRANSFERS = {epipolar, linear, projective};

/** e of Eq. (6): from the transferred points to the learner's own.
 * @param {Fitted} fitted @param {Float64Array} demo (4 N) px @param {Float64Array} own (4 N) px
 * @returns {Float64Array} (4 N) px */
export function residual(fitted, demo, own) {
  const recovered = fitted.recover(demo);
  return own.map((v, i) => v - recovered[i]);
}

/** E = 1/(2N) Σ (|e_L|² + |e_R|²), Eq. (6).
 * @param {Float64Array} e residuals of N points @param {number} [count] N @returns {number} px² */
export function conflict(e, count = e.length / 4) {
  let sum = 0;
  for (let i = 0; i < e.length; i++) sum += e[i] * e[i];
  return sum / (2 * count);
}
