/** The paper's transfer, Section 2.3: a point of the demonstrator is transferred to where its epipolar lines cross in
 * the learner's own views.
 *
 * Five constraints, of the pairs (l, L), (r, L), (l, R), (r, R) and (L, R), make A u = -B c, Eq. (4), solved by least
 * squares. Two misprints: Eq. (5) lacks that minus, and in the last row of A the coefficients of L are f13, f23 and
 * those of R are f31, f32, printed the other way round. Points about their centroids empty all f33.
 * @import {Transfer, Fitted, Grid} from "./transfers.js" */
import {leastSquares, svd} from "./algebra.js";
import {centred, centroid, fundamentals, quickFundamentals, scatter, scatters} from "./affine.js";

const SINGULAR = 1e-3; // determinant of two unit-norm lines below which all five constraints are solved together

/** @implements {Fitted} */
export class EpipolarTransfer {
  /** @param {Float64Array} demo @param {Float64Array} own */
  constructor(demo, own) {
    this.demoMean = centroid(demo);
    this.ownMean = centroid(own);
    /** f of the five pairs, (20) */
    this.f = fundamentals(scatters(centred(demo, this.demoMean), centred(own, this.ownMean)));
    const {A, B} = linearSystem(this.f);
    /** from centred [l; r] to centred [L; R], 4 x 4 */
    this.map = leastSquares(A, B.map(v => -v), 4, 4);
  }

  /** cond(A): how far Eq. (4) amplifies errors. */
  get condition() {
    const {sigma} = svd(linearSystem(this.f).A, 5, 4);
    return sigma[0] / sigma[3];
  }

  /** @param {Float64Array} images */
  recover(images) { return mapped(this.map, images, this.demoMean, this.ownMean); }
}

/** A and B of Eq. (4), 5 x 4 each. @param {Float64Array} f (20) */
export function linearSystem(f) {
  const A = new Float64Array(20), B = new Float64Array(20);
  for (let row = 0; row < 4; row++) {
    const demoView = row & 1, ownView = row >> 1;
    for (let k = 0; k < 2; k++) {
      B[4 * row + 2 * demoView + k] = f[4 * row + k];
      A[4 * row + 2 * ownView + k] = f[4 * row + 2 + k];
    }
  }
  A.set(f.subarray(16, 20), 16);
  return {A, B};
}

/** ownMean + map (image - demoMean), of each point.
 * @param {Float64Array} map 4 x 4 @param {Float64Array} images (4 M) px @param {Float64Array} demoMean
 * @param {Float64Array} ownMean */
export function mapped(map, images, demoMean, ownMean) {
  return images.map((_, i) => {
    const row = 4 * (i & 3), point = i - (i & 3);
    let sum = ownMean[i & 3];
    for (let k = 0; k < 4; k++) sum += map[row + k] * (images[point + k] - demoMean[k]);
    return sum;
  });
}

/** E of thousands of postures against one demonstrator. The first four constraints are two 2 x 2 systems, solved
 * exactly; the fifth is a rank-one correction of least squares.
 * @param {Float64Array} demo (4 N) px @returns {(grid: Grid, posture: number) => number} E, px² */
function energies(demo) {
  const D = centred(demo), of = {dd: scatter(D, D), oo: new Float64Array(16), do: new Float64Array(16)};
  const f = new Float64Array(20), map = new Float64Array(16);
  return ({own, scatters: squares}, posture) => {
    const from = posture * D.length;
    for (let k = 0; k < 16; k++) of.oo[k] = squares[16 * posture + k];
    scatter(D, own, of.do, from);
    quickFundamentals(of, f);
    if (!quickMap(f, map)) {
      const {A, B} = linearSystem(f);
      map.set(leastSquares(A, B.map(v => -v), 4, 4));
    }
    return meanSquare(D, own, from, map);
  };
}

/** E of Eq. (6) where points are transferred by a map of centred points.
 * @param {Float64Array} D centred demonstrator's images
 * @param {Float64Array} own centred own images, from index `from` on @param {number} from
 * @param {Float64Array} map 4 x 4 */
export function meanSquare(D, own, from, map) {
  let sum = 0;
  for (let i = 0; i < D.length; i += 4) {
    const a = D[i], b = D[i + 1], c = D[i + 2], d = D[i + 3];
    for (let k = 0; k < 4; k++) {
      const e = own[from + i + k] - map[4 * k] * a - map[4 * k + 1] * b - map[4 * k + 2] * c - map[4 * k + 3] * d;
      sum += e * e;
    }
  }
  return sum / (D.length / 2);
}

/** @param {Float64Array} f @param {Float64Array} map where the result is written @returns {boolean} false where lines are nearly parallel */
function quickMap(f, map) {
  const inverse = quickMap.inverse, lever = quickMap.lever;
  let square = 1;
  for (let o = 0; o < 2; o++) {
    const l = 8 * o, r = l + 4, det = f[l + 2] * f[r + 3] - f[l + 3] * f[r + 2];
    if (Math.abs(det) < SINGULAR) return false;
    inverse[4 * o] = -f[r + 3] / det;
    inverse[4 * o + 1] = f[l + 3] / det;
    inverse[4 * o + 2] = f[r + 2] / det;
    inverse[4 * o + 3] = -f[l + 2] / det;
    for (let d = 0; d < 2; d++) {
      for (let k = 0; k < 2; k++) for (let j = 0; j < 2; j++)
        map[8 * o + 4 * k + 2 * d + j] = inverse[4 * o + 2 * k + d] * f[8 * o + 4 * d + j];
      lever[2 * o + d] = inverse[4 * o + d] * f[16 + 2 * o] + inverse[4 * o + 2 + d] * f[17 + 2 * o];
      square += lever[2 * o + d] ** 2;
    }
  }
  for (let q = 0; q < 4; q++) {
    const violated = (f[16] * map[q] + f[17] * map[4 + q] + f[18] * map[8 + q] + f[19] * map[12 + q]) / square;
    for (let o = 0; o < 2; o++) for (let k = 0; k < 2; k++) map[8 * o + 4 * k + q] -= violated
      * (inverse[4 * o + 2 * k] * lever[2 * o] + inverse[4 * o + 2 * k + 1] * lever[2 * o + 1]);
  }
  return true;
}
quickMap.inverse = new Float64Array(8);
quickMap.lever = new Float64Array(4);

/** @type {Transfer} */
export const epipolar = {fit: (demo, own) => new EpipolarTransfer(demo, own), energies};
