/** Projective combination of views: exact for parallel pinhole cameras, in both of whose images a point has one depth.
 *
 * ŷᵢ = (a₀ + Aᵀuᵢ) / ρᵢ with ρᵢ = 1 + p·uᵢ. uᵢ are the affine coordinates of point i in [l r], and L and R share p. a₀
 * and A are linear given p, which comes from a few Gauss-Newton steps of variable projection (Golub & Pereyra 1973,
 * with Kaufman's Jacobian), held near 0, the affine camera, by a weak prior.
 * @import {Transfer, Fitted, Grid} from "./transfers.js" */
import {centred, centroid} from "./affine.js";
import {affineShape} from "./linear.js";

const STEPS = 3;
const PRIOR = 3e-4; // weight of |p|² beside the squared residuals, relative to the mean square of the centred own points
const MAX_P = 0.6, MIN_DEPTH = 0.15; // bounds of |p| and ρ: no point is at infinity or behind the camera
const MIN_SQUARE = 1e-12; // px²: of own points that are all in one place

/** @implements {Fitted} */
export class ProjectiveTransfer {
  /** @param {Float64Array} demo @param {Float64Array} own */
  constructor(demo, own) {
    const shape = affineShape(demo), fit = fitter(coordinates(shape, demo.length / 4));
    this.demoMean = shape.mean;
    this.ownMean = centroid(own);
    this.condition = shape.sigma[0] / shape.sigma[2];
    /** from centred [l; r] to u, 4 x 3 */
    this.basis = Float64Array.from({length: 12}, (_, i) => {
      const row = Math.floor(i / 3), k = i % 3;
      return shape.sigma[k] > 0 ? shape.V[4 * row + k] * Math.sqrt(demo.length / 4) / shape.sigma[k] : 0;
    });
    const {p, coefficients} = fit(centred(own, this.ownMean), 0);
    this.p = Float64Array.from(p);
    this.coefficients = Float64Array.from(coefficients);
  }

  /** @param {Float64Array} images */
  recover(images) {
    const {demoMean, ownMean, basis, p, coefficients: c} = this, found = new Float64Array(images.length), u = [0, 0, 0];
    for (let i = 0; i < images.length; i += 4) {
      let depth = 1;
      for (let k = 0; k < 3; k++) {
        u[k] = 0;
        for (let j = 0; j < 4; j++) u[k] += (images[i + j] - demoMean[j]) * basis[3 * j + k];
        depth += u[k] * p[k];
      }
      depth = Math.max(depth, MIN_DEPTH);
      for (let k = 0; k < 4; k++)
        found[i + k] = ownMean[k] + (c[k] + u[0] * c[4 + k] + u[1] * c[8 + k] + u[2] * c[12 + k]) / depth;
    }
    return found;
  }
}

/** h = [1; u] of each point, (4 N), with columns of length √N. @param {{U: Float64Array}} shape @param {number} count */
const coordinates = ({U}, count) => U.map((_, i) => i & 3 ? Math.sqrt(count) * U[i - 1] : 1);

/** What fits p and the coefficients to any own images of one demonstrator. @param {Float64Array} h (4 N) */
function fitter(h) {
  const N = h.length / 4, H = new Float64Array(4 * N), inverted = new Float64Array(4 * N); // (HᵀH)⁻¹Hᵀ, point by point
  const found = new Float64Array(4 * N), A = new Float64Array(12 * N), p = new Float64Array(3), square = new Float64Array(16);
  const coefficients = new Float64Array(16), product = new Float64Array(12), normal = new Float64Array(9), right = new Float64Array(3);

  /** coefficients = inverted · own: 4 x 4, of h for each own coordinate. @param {Float64Array} own @param {number} from */
  const combine = (own, from) => {
    coefficients.fill(0);
    for (let i = 0; i < 4 * N; i += 4) for (let a = 0; a < 4; a++) {
      const v = inverted[i + a];
      for (let k = 0; k < 4; k++) coefficients[4 * a + k] += v * own[from + i + k];
    }
  };

  /** @param {Float64Array} own (4 N) px, centred, from index `from` on @param {number} from */
  return (own, from) => {
    p.fill(0);
    let total = 0;
    for (let i = 0; i < 4 * N; i++) {
      total += own[from + i] ** 2;
      H[i] = h[i];
      inverted[i] = h[i] / N; // where p = 0 the columns of H are orthogonal
    }
    const prior = PRIOR / N * Math.max(total, MIN_SQUARE);
    for (let step = 0; step < STEPS; step++) {
      // The Jacobian is what H cannot make of -A, A = [ŷ uⱼ/ρ]
      combine(own, from);
      normal.fill(0);
      right.fill(0);
      for (let i = 0; i < 4 * N; i += 4) for (let k = 0; k < 4; k++) {
        const y = H[i] * coefficients[k] + H[i + 1] * coefficients[4 + k] + H[i + 2] * coefficients[8 + k] + H[i + 3] * coefficients[12 + k];
        found[i + k] = y;
        for (let j = 0; j < 3; j++) A[3 * (i + k) + j] = y * H[i + 1 + j];
      }
      for (let k = 0; k < 4; k++) {
        product.fill(0); // inverted · A of this own coordinate, 4 x 3
        for (let i = 0; i < 4 * N; i += 4) for (let a = 0; a < 4; a++)
          for (let j = 0; j < 3; j++) product[3 * a + j] += inverted[i + a] * A[3 * (i + k) + j];
        for (let i = 0; i < 4 * N; i += 4) for (let j = 0; j < 3; j++) {
          const left = A[3 * (i + k) + j] - H[i] * product[j] - H[i + 1] * product[3 + j] - H[i + 2] * product[6 + j] - H[i + 3] * product[9 + j];
          for (let a = 0; a < 3; a++) normal[3 * a + j] += A[3 * (i + k) + a] * left;
          right[j] += A[3 * (i + k) + j] * (own[from + i + k] - found[i + k]);
        }
      }
      for (let j = 0; j < 3; j++) {
        normal[4 * j] += prior;
        right[j] += prior * p[j];
      }
      subtractSolution(normal, right, p);
      const scale = MAX_P / Math.max(Math.hypot(p[0], p[1], p[2]), MAX_P);
      for (let j = 0; j < 3; j++) p[j] *= scale;
      square.fill(0);
      for (let i = 0; i < 4 * N; i += 4) {
        const depth = Math.max(1 + h[i + 1] * p[0] + h[i + 2] * p[1] + h[i + 3] * p[2], MIN_DEPTH);
        for (let a = 0; a < 4; a++) H[i + a] = h[i + a] / depth;
        for (let a = 0; a < 4; a++) for (let b = 0; b < 4; b++) square[4 * a + b] += H[i + a] * H[i + b];
      }
      invert4(square);
      for (let i = 0; i < 4 * N; i += 4) for (let a = 0; a < 4; a++)
        inverted[i + a] = square[4 * a] * H[i] + square[4 * a + 1] * H[i + 1] + square[4 * a + 2] * H[i + 2] + square[4 * a + 3] * H[i + 3];
    }
    combine(own, from);
    return {p, coefficients, H};
  };
}

/** @param {Float64Array} demo @returns {(grid: Grid, posture: number) => number} */
function energies(demo) {
  const fit = fitter(coordinates(affineShape(demo), demo.length / 4));
  return ({own}, posture) => {
    const from = posture * demo.length, {coefficients: c, H} = fit(own, from);
    let sum = 0;
    for (let i = 0; i < H.length; i += 4) for (let k = 0; k < 4; k++) {
      const e = own[from + i + k] - H[i] * c[k] - H[i + 1] * c[4 + k] - H[i + 2] * c[8 + k] - H[i + 3] * c[12 + k];
      sum += e * e;
    }
    return sum / (H.length / 2);
  };
}

/** p -= normal⁻¹ right, by Cramer's rule; normal is 3 x 3. @param {Float64Array} m @param {Float64Array} r @param {Float64Array} p */
function subtractSolution([a, b, c, d, e, f, g, h, i], [x, y, z], p) {
  const A = e * i - f * h, B = f * g - d * i, C = d * h - e * g, det = a * A + b * B + c * C;
  p[0] -= (x * A + b * (f * z - y * i) + c * (y * h - e * z)) / det;
  p[1] -= (a * (y * i - f * z) + x * B + c * (d * z - y * g)) / det;
  p[2] -= (a * (e * z - y * h) + b * (y * g - d * z) + x * C) / det;
}

/** Invert a symmetric positive-definite 4 x 4 matrix in place, by Gauss and Jordan without pivots. @param {Float64Array} m */
function invert4(m) {
  for (let k = 0; k < 4; k++) {
    const pivot = 1 / m[5 * k];
    for (let j = 0; j < 4; j++) m[4 * k + j] = j === k ? pivot : m[4 * k + j] * pivot;
    for (let i = 0; i < 4; i++) if (i !== k) {
      const factor = m[4 * i + k];
      for (let j = 0; j < 4; j++) m[4 * i + j] = j === k ? -factor * pivot : m[4 * i + j] - factor * m[4 * k + j];
    }
  }
}

/** @type {Transfer} */
export const projective = {fit: (demo, own) => new ProjectiveTransfer(demo, own), energies};
