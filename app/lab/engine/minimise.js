/** The smallest E of images that a model predicts: Levenberg and Marquardt's method in a box. */
import {clamp, dot, largest, solve, symmetricEigen} from "./algebra.js";

const MAX_ROUNDS = 8;
const DIFFERENCE_RAD = 1e-5; // of difference quotients
const MIN_STEP_RAD = 0.01 * Math.PI / 180;
const MIN_GAIN = 1e-4; // share of E: a round that gains less is the last
const DAMPINGS = [0, 1], REGULAR = 1e-9; // REGULAR keeps the normal equations regular
const MAX_STEP_RAD = Math.PI; // longer steps are along directions that no image determines
const ROUNDING = 1e-12; // of the largest curvature, below which one may be a rounding error

/** @param {(thetas: number[][]) => Float64Array[]} residualsAt postures → residuals of the images predicted there
 * @param {(e: Float64Array) => number} energy E of residuals @param {number[]} start @param {number[]} low
 * @param {number[]} high
 * @returns {{theta: number[], E: number, startE: number}} where E is least, and E there and at the start */
export function minimise(residualsAt, energy, start, low, high) {
  let theta = start, E = Infinity, startE = NaN, candidates = [start];
  for (let round = 0; round < MAX_ROUNDS; round++) {
    const inward = candidates.map(at => at.map((v, k) => v > high[k] - DIFFERENCE_RAD ? -DIFFERENCE_RAD : DIFFERENCE_RAD));
    const asked = candidates.flatMap((at, c) => [at, ...at.map((_, k) => at.map((v, i) => i === k ? v + inward[c][k] : v))]);
    const all = residualsAt(asked), each = start.length + 1;
    const energies = candidates.map((_, c) => energy(all[c * each]));
    if (round === 0) startE = energies[0];
    const best = energies.indexOf(Math.min(...energies));
    if (!(energies[best] < E * (1 - MIN_GAIN))) break;
    theta = candidates[best];
    E = energies[best];
    const [e, ...beside] = all.slice(best * each, (best + 1) * each);
    const J = beside.map((column, k) => column.map((v, i) => (v - e[i]) / inward[best][k]));
    const gradient = J.map(column => dot(column, e)), normal = J.map(a => J.map(b => dot(a, b)));
    const barred = theta.map((v, k) => v <= low[k] && gradient[k] > 0 || v >= high[k] && gradient[k] < 0);
    barred.forEach((is, k) => { if (is) gradient[k] = 0; });
    let steps = dampedSteps(gradient, normal, barred);
    if (Math.max(...steps.map(largest)) > MAX_STEP_RAD) steps = dampedSteps(gradient, stiffened(normal), barred);
    const gain = dot(gradient, steps[0]);
    candidates = steps.map(step => theta.map((v, k) => clamp(v - step[k], low[k], high[k])));
    if (!(gain >= MIN_GAIN * dot(e, e) && Math.max(...steps.map(largest)) >= MIN_STEP_RAD)) break;
  }
  return {theta, E, startE};
}

/** (H + λ diag H)⁻¹ g over the joints that are not barred, for each damping λ.
 * @param {number[]} gradient @param {number[][]} H @param {boolean[]} barred */
function dampedSteps(gradient, H, barred) {
  const floor = 1e-12 * Math.max(H.reduce((sum, row, i) => sum + row[i], 0), 1e-300);
  return DAMPINGS.map(damping => solve(H.map((row, i) => row.map((v, j) => barred[i] || barred[j] ? +(i === j)
    : v + (i === j ? (damping + REGULAR) * (v + floor) : 0))), gradient));
}

/** The same but along directions that no image determines: there as stiff as along the stiffest. @param {number[][]} H */
function stiffened(H) {
  const n = H.length, {values, vectors} = symmetricEigen(Float64Array.from(H.flat()), n), most = values[n - 1];
  const stiffness = values.map(v => v > ROUNDING * most ? v : most);
  return H.map((row, i) => row.map((_, j) => vectors.reduce((sum, v, k) => sum + stiffness[k] * v[i] * v[j], 0)));
}
