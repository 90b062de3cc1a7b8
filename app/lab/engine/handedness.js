/** One stereo head cannot see a body as its own mirror image, but a transfer can: a body whose points are nearly
 * symmetric fits its mirrored posture. Where only a mirror image of the demonstrator fits, residuals get three more
 * columns.
 *
 * With orthonormal coordinates U of one body and images Y of the other, M = YᵀU is the best linear map. If it reflects,
 * the nearest map that does not is M without its smallest singular value s₃, which leaves s₃² px² more (Eckart & Young
 * 1936). */
import {svd, symmetricEigen} from "./algebra.js";
import {centred, centroid} from "./affine.js";

const FLAT_STD = 3; // standard deviations of the noise up to which depth hides the handedness
const MIN_SHARE = 1e-6; // of the largest extent of the images: a smaller third one is a rounding error

/** Coordinates along three directions: (4 N) → (3 N). @param {Float64Array} images @param {Float64Array} V 4 x 4 */
function along(images, V) {
  const found = new Float64Array(images.length / 4 * 3);
  for (let i = 0, j = 0; i < images.length; i += 4, j += 3) for (let k = 0; k < 3; k++)
    for (let c = 0; c < 4; c++) found[j + k] += images[i + c] * V[4 * c + k];
  return found;
}

/** @param {ArrayLike<number>} m 3 x 3 */
const determinant = m => m[0] * (m[4] * m[8] - m[5] * m[7]) + m[1] * (m[5] * m[6] - m[3] * m[8]) + m[2] * (m[3] * m[7] - m[4] * m[6]);

/** What finds mirror images of a body.
 * @param {Float64Array} demo (4 N) px of the body
 * @param {Float64Array} matches (4 M) px of all bodies in sight: they tell in which directions images differ
 * @param {number} noisePx standard deviation of a coordinate
 * @returns {null | ((own: Float64Array) => Float64Array | null)} null for a body too flat to tell; else own images
 * (4 N) px → residuals (3 N) px, null where the map does not reflect */
export function mirrorFinder(demo, matches, noisePx) {
  const N = demo.length / 4, {V: axes} = svd(centred(matches), matches.length / 4, 4);
  const shape = along(centred(demo), axes), {U, sigma, V} = svd(shape, N, 3);
  if (!(sigma[2] > Math.max(FLAT_STD * noisePx * Math.sqrt(N), MIN_SHARE * sigma[0]))) return null;
  const sign = Math.sign(determinant(V));
  return own => {
    const Y = along(centred(own, centroid(own)), axes), M = new Float64Array(9), square = new Float64Array(9);
    for (let i = 0; i < 3 * N; i += 3) for (let a = 0; a < 3; a++) for (let b = 0; b < 3; b++) M[3 * a + b] += Y[i + a] * U[i + b];
    if (!(sign * determinant(M) < 0)) return null;
    for (let a = 0; a < 3; a++) for (let b = 0; b < 3; b++) for (let k = 0; k < 3; k++) square[3 * a + b] += M[3 * k + a] * M[3 * k + b];
    const q = symmetricEigen(square, 3).vectors[0]; // M q = s₃ p
    const missing = new Float64Array(3 * N);
    for (let i = 0; i < 3 * N; i += 3) {
      const weight = U[i] * q[0] + U[i + 1] * q[1] + U[i + 2] * q[2];
      for (let a = 0; a < 3; a++) missing[i + a] = weight * (M[3 * a] * q[0] + M[3 * a + 1] * q[1] + M[3 * a + 2] * q[2]);
    }
    return missing;
  };
}
