/** Affine epipolar geometry of the four views: Eqs. (1) to (3) of "View-Based Imitation Learning by Conflict Resolution
 * with Epipolar Geometry" (IROS 2001), here and in the other modules "the paper".
 *
 * A match of the images [p] and [q] obeys f13 x_p + f23 y_p + f31 x_q + f32 y_q + f33 = 0. f = (f13, f23, f31, f32) has
 * length 1. Points about their centroid make f33 vanish.
 *
 * Images are flat (4 N) px: the demonstrator's are x_l, y_l, x_r, y_r of each point, the learner's own x_L, y_L, x_R,
 * y_R. */
import {symmetricEigen} from "./algebra.js";

/** The views l, r, L, R as 0, 1, 2, 3: all pairs [p], [q], in the order of Eq. (4), then [l, r]. */
export const PAIRS = [[0, 2], [1, 2], [0, 3], [1, 3], [2, 3], [0, 1]];

/** @param {Float64Array} images @returns {Float64Array} (4) px */
export function centroid(images) {
  const mean = new Float64Array(4);
  for (let i = 0; i < images.length; i++) mean[i & 3] += images[i];
  return mean.map(sum => sum / (images.length / 4));
}

/** Images about their centroid. @param {Float64Array} images @param {Float64Array} [mean] */
export const centred = (images, mean = centroid(images)) => images.map((v, i) => v - mean[i & 3]);

/** Σ aᵢ bᵢᵀ over the points.
 * @param {Float64Array} a (4 N) @param {Float64Array} b (4 N), from index `from` on
 * @param {Float64Array} [sum] 4 x 4, where the result is written @param {number} [from] */
export function scatter(a, b, sum = new Float64Array(16), from = 0) {
  sum.fill(0);
  for (let i = 0; i < a.length; i += 4) for (let p = 0; p < 4; p++) {
    const v = a[i + p];
    for (let q = 0; q < 4; q++) sum[4 * p + q] += v * b[from + i + q];
  }
  return sum;
}

/** The scatter matrices of four views, about the centroids: demonstrator with itself, learner with itself, and both.
 * @typedef {{dd: Float64Array, oo: Float64Array, do: Float64Array}} Scatters
 * @param {Float64Array} demo (4 N), centred @param {Float64Array} own (4 N), centred @returns {Scatters} */
export const scatters = (demo, own) => ({dd: scatter(demo, demo), oo: scatter(own, own), do: scatter(demo, own)});

const W = new Float64Array(16);

/** W of Eq. (2) for one of PAIRS. The paper prints 1/n for 1/N there. @param {Scatters} of @param {number} pair */
function scatterOf({dd, oo, do: between}, pair) {
  const [p, q] = PAIRS[pair], x = 2 * (p & 1), y = 2 * (q & 1);
  const P = p < 2 ? dd : oo, Q = q < 2 ? dd : oo, M = p < 2 && q >= 2 ? between : P;
  for (let i = 0; i < 2; i++) for (let j = 0; j < 2; j++) {
    W[4 * i + j] = P[4 * (x + i) + x + j];
    W[4 * i + j + 8 + 2] = Q[4 * (y + i) + y + j];
    W[4 * i + j + 2] = W[4 * (j + 2) + i] = M[4 * (x + i) + y + j];
  }
  return W;
}

/** f of the first pairs of PAIRS: the eigenvector of the smallest eigenvalue of W, Eq. (2). Its sign is arbitrary.
 * @param {Scatters} of @param {number} [count] 5 pairs make Eq. (4)
 * @param {Float64Array} [f] (4 count), where the result is written */
export function fundamentals(of, count = 5, f = new Float64Array(4 * count)) {
  for (let pair = 0; pair < count; pair++) f.set(symmetricEigen(scatterOf(of, pair), 4).vectors[0], 4 * pair);
  return f;
}

/** The same for thousands of postures: `smallestEigenvector` first, Jacobi's rotations where that cannot decide.
 * @param {Scatters} of @param {Float64Array} f (20), where the result is written */
export function quickFundamentals(of, f) {
  const {dd, oo, do: m} = of;
  for (let pair = 0; pair < 4; pair++) {
    const x = 2 * (pair & 1), y = pair & 2;
    const found = smallestEigenvector(dd[5 * x], dd[5 * x + 1], dd[5 * x + 5], oo[5 * y], oo[5 * y + 1], oo[5 * y + 5],
      m[4 * x + y], m[4 * x + y + 1], m[4 * x + 4 + y], m[4 * x + 5 + y], f, 4 * pair);
    if (!found) f.set(symmetricEigen(scatterOf(of, pair), 4).vectors[0], 4 * pair);
  }
  const found = smallestEigenvector(oo[0], oo[1], oo[5], oo[10], oo[11], oo[15], oo[2], oo[3], oo[6], oo[7], f, 16);
  if (!found) f.set(symmetricEigen(scatterOf(of, 4), 4).vectors[0], 16);
}

/** Unit eigenvector of the smallest eigenvalue λ of W = [[P, M], [Mᵀ, Q]], positive semi-definite, without a loop over
 * matrices: λ is the smallest root of the characteristic polynomial, by Laguerre's iteration from 0, which is monotone.
 * With f = [x; y], (W - λ) f = 0 gives y = -(Q - λ)⁻¹ Mᵀ x, and x spans the kernel of the Schur complement S = P - λ -
 * M (Q - λ)⁻¹ Mᵀ.
 * @param {number} p00 P, as p00, p01, p11 @param {number} p01 @param {number} p11 @param {number} q00 Q, likewise
 * @param {number} q01 @param {number} q11 @param {number} m00 M, row by row @param {number} m01 @param {number} m10
 * @param {number} m11 @param {Float64Array} f where the result is written @param {number} at from this index on
 * @returns {boolean} false where the two smallest eigenvalues nearly coincide: nothing is written then */
export function smallestEigenvector(p00, p01, p11, q00, q01, q11, m00, m01, m10, m11, f, at) {
  // det(W - λ) = λ⁴ - s3 λ³ + s2 λ² - s1 λ + s0, from M adj(Q) and adj(P) M
  const a00 = m00 * q11 - m01 * q01, a01 = m01 * q00 - m00 * q01, a10 = m10 * q11 - m11 * q01, a11 = m11 * q00 - m10 * q01;
  const b00 = m00 * p11 - m10 * p01, b01 = m01 * p11 - m11 * p01, b10 = m10 * p00 - m00 * p01, b11 = m11 * p00 - m01 * p01;
  const detP = p00 * p11 - p01 * p01, detQ = q00 * q11 - q01 * q01, detM = m00 * m11 - m01 * m10;
  const traceP = p00 + p11, traceQ = q00 + q11, s3 = traceP + traceQ;
  const s2 = detP + detQ + traceP * traceQ - (m00 * m00 + m01 * m01 + m10 * m10 + m11 * m11);
  const s0 = detP * detQ - (b00 * a00 + b01 * a01 + b10 * a10 + b11 * a11) + detM * detM;
  const s1 = traceP * detQ + traceQ * detP
    - ((b00 + a00) * m00 + (b01 + a01) * m01 + (b10 + a10) * m10 + (b11 + a11) * m11);
  const cube = s3 * s3 * s3, floor = 1e-20 * cube * cube;
  let root = 0, value = s0, slope = -s1, halfCurvature = s2;
  for (let i = 0; i < 20; i++) {
    const step = 4 * value / (Math.sqrt(Math.max(9 * slope * slope - 24 * halfCurvature * value, floor)) - slope);
    root += step;
    if (!(step > 1e-6 * s3)) break; // the steps shrink cubically: the next one would be rounding
    let c3 = root - s3, c2 = c3 * root + s2; // divided by (λ - root) again and again, the remainders are f, f', f''/2
    const c1 = c2 * root - s1;
    value = c1 * root + s0;
    c3 += root;
    c2 += c3 * root;
    slope = c2 * root + c1;
    c3 += root;
    halfCurvature = c3 * root + c2;
  }
  const c = q00 - root, d = q11 - root, det = c * d - q01 * q01;
  const n00 = a00 - root * m00, n01 = a01 - root * m01, n10 = a10 - root * m10, n11 = a11 - root * m11; // M adj(Q - λ)
  let S00 = (p00 - root) * det - (n00 * m00 + n01 * m01), S11 = (p11 - root) * det - (n10 * m10 + n11 * m11);
  const S01 = p01 * det - (n00 * m10 + n01 * m11);
  if (!(S00 + S11 > 1e-5 * cube)) return false;
  S00 += Math.abs(S01); // adj S = s x xᵀ times (1, ±1), with the sign of x0 x1 for which nothing cancels
  S11 += Math.abs(S01);
  const x0 = S11, x1 = S01 > 0 ? -S00 : S00;
  const f0 = x0 * det, f1 = x1 * det, f2 = -n00 * x0 - n10 * x1, f3 = -n01 * x0 - n11 * x1;
  const unit = 1 / Math.sqrt(f0 * f0 + f1 * f1 + f2 * f2 + f3 * f3);
  f[at] = f0 * unit;
  f[at + 1] = f1 * unit;
  f[at + 2] = f2 * unit;
  f[at + 3] = f3 * unit;
  return true;
}

/** Epipolar lines: a x + b y + c = 0 px in the view `into`, of a point seen in the view `from`. (a, b) has length 1.
 * @typedef {{into: number, from: number, a: number, b: number, c: number}} Line */
export class EpipolarGeometry {
  /** Of all six pairs of views. f33 is Eq. (3), whose u_0 is the centroid.
   * @param {Float64Array} demo (4 N) px of at least 5 points that all four views show
   * @param {Float64Array} own (4 N) px */
  constructor(demo, own) {
    const mean = [centroid(demo), centroid(own)];
    this.f = fundamentals(scatters(centred(demo, mean[0]), centred(own, mean[1])), 6);
    this.f33 = PAIRS.map(([p, q], pair) => {
      const at = (/** @type {number} */ view, /** @type {number} */ k) => mean[view >> 1][2 * (view & 1) + k];
      const [f13, f23, f31, f32] = this.f.subarray(4 * pair);
      return -(f13 * at(p, 0) + f23 * at(p, 1) + f31 * at(q, 0) + f32 * at(q, 1));
    });
  }

  /** The twelve lines of one point, three in each view.
   * @param {ArrayLike<number>} demo its x_l, y_l, x_r, y_r px
   * @param {ArrayLike<number>} own its x_L, y_L, x_R, y_R px @returns {Line[]} */
  lines(demo, own) {
    return PAIRS.flatMap(([p, q], pair) => {
      const at = (/** @type {number} */ view, /** @type {number} */ k) => (view < 2 ? demo : own)[2 * (view & 1) + k];
      const [f13, f23, f31, f32] = this.f.subarray(4 * pair), f33 = this.f33[pair];
      return [
        line(q, p, f31, f32, f33 + f13 * at(p, 0) + f23 * at(p, 1)),
        line(p, q, f13, f23, f33 + f31 * at(q, 0) + f32 * at(q, 1)),
      ];
    });
  }
}

/** @param {number} into @param {number} from @param {number} a @param {number} b @param {number} c @returns {Line} */
function line(into, from, a, b, c) {
  const unit = 1 / Math.hypot(a, b);
  return {into, from, a: a * unit, b: b * unit, c: c * unit};
}
