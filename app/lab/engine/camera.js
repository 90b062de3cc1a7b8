/**
 * Pinhole cameras. OpenCV's axes: z ahead, x to the right, y down. Images are flat arrays (4 N) px: x, y of each point
 * in the left image of a pair, then x, y in the right one.
 *
 * @typedef {{rotation: number[], centre: number[], focal: number[], principal: number[], width: number, height: number}}
 *   Camera rotation: R_world_camera, 9 numbers row by row; centre: of projection, m; focal, principal: (x, y) px
 * @typedef {[Camera, Camera]} Pair left and right camera
 */

/**
 * Project points of the world into both images of a pair.
 *
 * @param {Pair} pair
 * @param {Float64Array} points (3 N) m
 * @returns {{images: Float64Array, seen: Uint8Array}} images: (4 N) px; seen: (2 N), 1 for a point that is in front of
 *   the left and the right camera and inside its image
 */
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

/**
 * @param {Camera} camera
 * @param {ArrayLike<number>} point m in the world
 * @param {number} [nearest] depth to which nearer points are moved back, so that they can be drawn somewhere
 * @returns {[number, number, number]} x, y px and depth m
 */
export function projectPoint({rotation: R, centre, focal, principal}, point, nearest = -Infinity) {
  const x = point[0] - centre[0], y = point[1] - centre[1], z = point[2] - centre[2];
  const depth = Math.max(R[2] * x + R[5] * y + R[8] * z, nearest);
  return [
    (R[0] * x + R[3] * y + R[6] * z) * (focal[0] / depth) + principal[0],
    (R[1] * x + R[4] * y + R[7] * z) * (focal[1] / depth) + principal[1],
    depth,
  ];
}

/**
 * The point at a depth on the ray of an image point.
 *
 * @param {Camera} camera
 * @param {number} x px
 * @param {number} y px
 * @param {number} depth m
 */
export const backProject = (camera, x, y, depth) => ray(camera, x, y).map((v, i) => camera.centre[i] + depth * v);

/**
 * Where the two rays of a point pass nearest to each other: the midpoint. It is drawn in the scene, and the learner has
 * no use of it.
 *
 * @param {Pair} pair
 * @param {ArrayLike<number>} image x, y in the left image, x, y in the right one, px
 * @returns {number[]} m
 */
export function triangulate([left, right], image) {
  const a = ray(left, image[0], image[1]), b = ray(right, image[2], image[3]), base = right.centre.map((c, i) => c - left.centre[i]);
  const product = (/** @type {number[]} */ p, /** @type {number[]} */ q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const aa = product(a, a), ab = product(a, b), bb = product(b, b), pa = product(a, base), pb = product(b, base);
  const half = 0.5 / (aa * bb - ab * ab), s = half * (bb * pa - ab * pb), t = half * (ab * pa - aa * pb);
  return a.map((_, i) => s * a[i] + t * b[i] + 0.5 * (left.centre[i] + right.centre[i]));
}

/** Direction of an image point's ray in the world, 1 long along the optical axis. @param {Camera} camera @param {number} x @param {number} y */
function ray({rotation: R, focal, principal}, x, y) {
  const a = (x - principal[0]) / focal[0], b = (y - principal[1]) / focal[1];
  return [0, 3, 6].map(i => R[i] * a + R[i + 1] * b + R[i + 2]);
}
