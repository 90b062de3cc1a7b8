/** Linear combination of views (Ullman & Basri 1991): each own image is an affine function of the demonstrator's shape.
 *
 * For affine cameras the centred [l r] = U Σ Vᵀ has rank 3, and the own images are the combination of U's first three
 * columns that is nearest to them. No lines are intersected, so none can be parallel.
 * @import {Transfer, Fitted, Grid} from "./transfers.js" */
import {svd} from "./algebra.js";
import {centred, centroid, scatter} from "./affine.js";
import {mapped, meanSquare} from "./epipolar.js";

/** The demonstrator's affine shape.
 * @param {Float64Array} demo (4 N) px
 * @returns {{mean: Float64Array, U: Float64Array, sigma: number[], V: Float64Array}} of the centred images; a
 * singular value within a rounding error is 0 */
export function affineShape(demo) {
  const mean = centroid(demo), {U, sigma, V} = svd(centred(demo, mean), demo.length / 4, 4);
  const smallest = sigma[0] * Number.EPSILON * demo.length / 4;
  return {mean, U, sigma: sigma.map(s => s > smallest ? s : 0), V};
}

/** The transposed pseudo-inverse of rank 3 of the centred images, (4 N). @param {{U: Float64Array, sigma: number[], V: Float64Array}} shape */
function pseudoInverse({U, sigma, V}) {
  return U.map((_, i) => {
    const point = i - (i & 3);
    let sum = 0;
    for (let k = 0; k < 3; k++) if (sigma[k] > 0) sum += U[point + k] / sigma[k] * V[4 * (i & 3) + k];
    return sum;
  });
}

/** @implements {Fitted} */
export class LinearTransfer {
  /** @param {Float64Array} demo @param {Float64Array} own */
  constructor(demo, own) {
    const shape = affineShape(demo);
    this.demoMean = shape.mean;
    this.ownMean = centroid(own);
    this.condition = shape.sigma[0] / shape.sigma[2]; // σ1/σ3: infinite for points in one plane
    this.map = scatter(centred(own, this.ownMean), pseudoInverse(shape));
  }

  /** @param {Float64Array} images */
  recover(images) { return mapped(this.map, images, this.demoMean, this.ownMean); }
}

/** @param {Float64Array} demo @returns {(grid: Grid, posture: number) => number} */
function energies(demo) {
  const shape = affineShape(demo), D = centred(demo, shape.mean), inverse = pseudoInverse(shape);
  const transposed = new Float64Array(16), map = new Float64Array(16);
  return ({own}, posture) => {
    const from = posture * D.length;
    scatter(inverse, own, transposed, from);
    for (let p = 0; p < 4; p++) for (let q = 0; q < 4; q++) map[4 * p + q] = transposed[4 * q + p];
    return meanSquare(D, own, from, map);
  };
}

/** @type {Transfer} */
export const linear = {fit: (demo, own) => new LinearTransfer(demo, own), energies};
