/** Two arms of the same build and a stereo head: postures in, image points out, with noise and lost points from a seed.
 * @import {Joint, Link, BodyPoint} from "./kinematics.js" @import {Camera, Pair} from "./camera.js"
 * @typedef {"demonstrator" | "learner"} Who
 * @typedef {Object} Scene what Python writes, to the last digit; angles in rad, lengths in m
 * @property {string} title
 * @property {string[]} joints symbols of the moving joints
 * @property {string[]} names of the moving joints, with their symbols
 * @property {number[]} lower limits of the moving joints
 * @property {number[]} upper
 * @property {number[]} demonstrator its posture at first
 * @property {number[]} start the learner's posture at first
 * @property {Joint[]} chain what moves of the arm
 * @property {Link[]} links
 * @property {Record<Who, number[]>} bases T_world_base
 * @property {Camera[]} cameras of the views l, r, L, R
 * @property {Record<string, BodyPoint[]>} layouts body points, by their number
 * @property {number[]} [gaze] what the eyes of l and r look at, m
 * @typedef {{images: Float64Array, seen: Uint8Array}} Look images of a body in a pair of views: (4 N) px, (2 N) 0 or
 * 1
 * @typedef {{demo: Float64Array, demoSeen: Uint8Array, own: Float64Array, ownSeen: Uint8Array}} Views all four
 * @typedef {{noisePx: number, missing: number, seed: number}} Disturbance noisePx: standard deviation of a
 * coordinate; missing: share of points that an image does not show */
import {median} from "./algebra.js";
import {centred, centroid} from "./affine.js";
import {project} from "./camera.js";
import {Arm} from "./kinematics.js";
import {Generator} from "./random.js";

const DEMO_STREAM = 0, OWN_STREAM = 1, REST_STREAM = 4; // of the seed
const REST_LOOKS = 8; // images of the own body at rest, from which the learner knows their noise
const NORMAL_MAD = 0.6745; // median of |x| for a standard normal x
const TYPICAL_PX = 70; // rms distance of image points from their centroid
const MAX_LAG = 3, MOVED_PX = 0.2, MOVED_STD = 5; // looks; px of typical images, times the noise: a motion shows

export class World {
  /** @param {Scene} scene @param {number | string} [layout] */
  constructor(scene, layout = Object.keys(scene.layouts)[0]) {
    this.scene = scene;
    this.body = scene.layouts[layout];
    const arm = (/** @type {Who} */ who) => new Arm(scene.chain, scene.links, scene.bases[who]);
    this.arms = {demonstrator: arm("demonstrator"), learner: arm("learner")};
    const [l, r, L, R] = scene.cameras;
    /** @type {Record<Who, Pair>} */
    this.pairs = {demonstrator: [l, r], learner: [L, R]};
  }

  /** An arm in its pair of views, undisturbed. @param {Who} who @param {ArrayLike<number>} theta @returns {Look} */
  look(who, theta) { return project(this.pairs[who], this.arms[who].points(theta, this.body)); }
}

/** What the learner gets to see. With equal seeds it sees the same; every look has a stream of the seed for itself. */
export class Observer {
  /** @param {World} world @param {Disturbance} disturbance @param {number[]} rest where the learner measures its noise */
  constructor(world, disturbance, rest) {
    this.world = world;
    this.disturbance = disturbance;
    this.noisePx = this.#noiseAt(rest); // standard deviation of a coordinate, px, as measured at rest
    this.last = /** @type {{key: string, look: Look} | null} */ (null);
  }

  /** @param {number[]} theta @param {number[]} thetaDemo @param {number} look which one it is, of the own body @returns {Views} */
  views(theta, thetaDemo, look) {
    const demo = this.demo(thetaDemo), own = this.own(theta, look);
    return {demo: demo.images, demoSeen: demo.seen, own: own.images, ownSeen: own.seen};
  }

  /** The demonstrator, looked at again only when it has moved. @param {number[]} theta */
  demo(theta) {
    const key = theta.join();
    if (this.last?.key !== key) this.last = {key, look: this.#disturbed(this.world.look("demonstrator", theta), [DEMO_STREAM, ...streamOf(theta)])};
    return this.last.look;
  }

  /** @param {number[]} theta @param {number} look */
  own(theta, look) { return this.#disturbed(this.world.look("learner", theta), [OWN_STREAM, look]); }

  /** How many looks to wait after a first motion until an image shows it, and whether that is known then: images of a
   * real camera may come late, and a learner cannot know before it has moved.
   * @param {Look} before @param {number[]} theta @param {number} look the number of the last look
   * @returns {number | null} null where the motion does not show at all */
  lag(before, theta, look) {
    const least = MOVED_PX * imageUnit(select(before.images, seenTwice(before.seen))) + MOVED_STD * this.noisePx;
    for (let lag = 0; lag <= MAX_LAG; lag++) {
      const after = this.own(theta, look + 1 + lag), both = seenTwice(before.seen).filter(i => seenTwice(after.seen).includes(i));
      const moves = both.map(i => Math.max(...[0, 1, 2, 3].map(k => Math.abs(after.images[4 * i + k] - before.images[4 * i + k]))));
      if (moves.length && median(moves) > least) return lag;
    }
    return null;
  }

  /** @param {Look} look @param {number[]} stream @returns {Look} */
  #disturbed({images, seen}, stream) {
    const {noisePx, missing, seed} = this.disturbance;
    if (!noisePx && !missing) return {images, seen};
    const random = new Generator([seed, ...stream]); // draws the same numbers for any amounts
    return {images: images.map(v => v + noisePx * random.normal()), seen: seen.map(v => +(random.random() >= missing) && v)};
  }

  /** @param {number[]} rest */
  #noiseAt(rest) {
    if (!this.disturbance.noisePx && !this.disturbance.missing) return 0;
    const still = this.world.look("learner", rest), steps = [];
    const looks = Array.from({length: REST_LOOKS}, (_, k) => this.#disturbed(still, k ? [REST_STREAM, k] : [REST_STREAM]));
    for (let k = 1; k < REST_LOOKS; k++) for (let i = 0; i < still.images.length; i++)
      if (looks[k].seen[i >> 1] && looks[k - 1].seen[i >> 1]) steps.push(Math.abs(looks[k].images[i] - looks[k - 1].images[i]));
    return steps.length ? median(steps) / (NORMAL_MAD * Math.SQRT2) : 0;
  }
}

/** Stream of a posture, its angles in millionths of a degree: in another posture there is other noise.
 * @param {number[]} theta */
function streamOf(theta) { return theta.map(v => Math.floor(v * (180 / Math.PI) * 1e6 + 0.5) >>> 0); }

export const MAX_LOOKS_WAITED = MAX_LAG;

/** Which points both cameras of a pair see. @param {Uint8Array} seen (2 N) */
export function seenTwice(seen) {
  const found = [];
  for (let i = 0; i < seen.length / 2; i++) if (seen[2 * i] && seen[2 * i + 1]) found.push(i);
  return found;
}

/** The images of some points. @param {Float64Array} images (4 N) @param {number[]} points */
export function select(images, points) {
  if (4 * points.length === images.length) return images;
  const found = new Float64Array(4 * points.length);
  points.forEach((i, k) => found.set(images.subarray(4 * i, 4 * i + 4), 4 * k));
  return found;
}

/** How many pixels one unit is, in which a typical body is as large as in images of 640 px. @param {Float64Array} images */
function imageUnit(images) {
  const away = centred(images, centroid(images)), square = away.reduce((sum, v) => sum + v * v, 0);
  return square > 0 ? Math.sqrt(square * 2 / images.length) / TYPICAL_PX : 1;
}
