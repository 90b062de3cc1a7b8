/** Pinhole cameras. OpenCV's axes: z ahead, x to the right, y down. Images are flat arrays (4 N) px: x, y of each point
 * in the left image of a pair, then x, y in the right one.
 * @typedef {{k1: number, k2: number, maxRadius: number}} Radial 1 + k1 r² + k2 r⁴ is the factor of the distance r
 * from the optical axis, in focal lengths; beyond maxRadius it is constant
 * @typedef {{rotation: number[], centre: number[], focal: number[], principal: number[], width: number, height:
 * number, distortion?: [Radial, Radial]}} Camera rotation: R_world_camera, 9 numbers row by row; centre: of
 * projection, m; focal, principal: (x, y) px; distortion: of the lens, and the part of it that was removed from the
 * images. Only replays have it @typedef {[Camera, Camera]} Pair left and right camera */
import {dot} from "./algebra.js";

const MAX_STRETCH = 1024, HALVINGS = 50; // of the search for an undistorted radius

/** Project points of the world into both images of a pair.
 * @param {Pair} pair @param {Float64Array} points (3 N) m
 * @returns {{images: Float64Array, seen: Uint8Array}} images: (4 N) px; seen: (2 N), 1 for a point that is in front
 * of the left and the right camera and inside its image */
export function project(pair, points) {
  const count = points.length / 3, images = new Float64Array(4 * count), seen = new Uint8Array(2 * count);
  pair.forEach((camera, side) => {
    for (let i = 0; i < count; i++) {
      const [x, y, depth] = projectPoint(camera, points.subarray(3 * i, 3 * i + 3));
      images[4 * i + 2 * side] = x;
      images[4 * i + 2 * side + 1] = y;
      seen[2 * i + side] = +(depth > 0 && x >= 0 && x <= camera.width && y >= 0 && y <= camera.height);
    }
  });
  return {images, seen};
}

/** @param {Camera} camera @param {ArrayLike<number>} point m in the world
 * @param {number} [nearest] depth to which nearer points are moved back, so that they can be drawn somewhere
 * @returns {[number, number, number]} x, y px and depth m */
export function projectPoint({rotation: R, centre, focal, principal, distortion}, point, nearest = -Infinity) {
  const x = point[0] - centre[0], y = point[1] - centre[1], z = point[2] - centre[2];
  const depth = Math.max(R[2] * x + R[5] * y + R[8] * z, nearest);
  const across = R[0] * x + R[3] * y + R[6] * z, down = R[1] * x + R[4] * y + R[7] * z;
  const bent = distortion ? stretch(distortion, (across * across + down * down) / (depth * depth)) : 1;
  return [across * (focal[0] / depth) * bent + principal[0], down * (focal[1] / depth) * bent + principal[1], depth];
}

/** By which factor a pinhole image moves outwards, given its radius squared. @param {[Radial, Radial]} distortion @param {number} square */
function stretch([lens, removed], square) {
  const factor = factorOf(lens, square);
  return factor * inverseFactor(removed, square * factor * factor);
}

/** @param {Radial} by @param {number} square of the radius */
function factorOf({k1, k2, maxRadius}, square) {
  const s = Math.min(square, maxRadius * maxRadius);
  return 1 + s * (k1 + k2 * s);
}

/** Undistorted over distorted radius, by halving. @param {Radial} by @param {number} square of the distorted radius */
function inverseFactor(by, square) {
  if (!by.k1 && !by.k2) return 1;
  let low = 0, high = 1;
  while (high * factorOf(by, high * high * square) < 1 && high < MAX_STRETCH) high *= 2;
  for (let i = 0; i < HALVINGS; i++) {
    const middle = (low + high) / 2;
    if (middle * factorOf(by, middle * middle * square) < 1) low = middle;
    else high = middle;
  }
  return high;
}

/** The point at a depth on the ray of an image point.
 * @param {Camera} camera @param {number} x px @param {number} y px @param {number} depth m */
export const backProject = (camera, x, y, depth) => ray(camera, x, y).map((v, i) => camera.centre[i] + depth * v);

/** Where the two rays of a point pass nearest to each other: the midpoint. It is drawn in the scene, and the learner
 * has no use of it.
 * @param {Pair} pair @param {ArrayLike<number>} image x, y in the left image, x, y in the right one, px
 * @returns {number[]} m */
export function triangulate([left, right], image) {
  const a = ray(left, image[0], image[1]), b = ray(right, image[2], image[3]), base = right.centre.map((c, i) => c - left.centre[i]);
  const aa = dot(a, a), ab = dot(a, b), bb = dot(b, b), pa = dot(a, base), pb = dot(b, base);
  const half = 0.5 / (aa * bb - ab * ab), s = half * (bb * pa - ab * pb), t = half * (ab * pa - aa * pb);
  return a.map((_, i) => s * a[i] + t * b[i] + 0.5 * (left.centre[i] + right.centre[i]));
}

/** Direction of an image point's ray in the world, 1 long along the optical axis. @param {Camera} camera @param {number} x @param {number} y */
function ray({rotation: R, focal, principal, distortion}, x, y) {
  let a = (x - principal[0]) / focal[0], b = (y - principal[1]) / focal[1];
  if (distortion) {
    const back = stretch([distortion[1], distortion[0]], a * a + b * b);
    a *= back;
    b *= back;
  }
  return [0, 3, 6].map(i => R[i] * a + R[i + 1] * b + R[i + 2]);
}
