/** E over the range of the learner's two joints, as in Fig. 7 of the paper. It asks for images at every posture, so it
 * is for people: a servo cannot see it.
 *
 * The learner's images do not depend on the demonstrator: they are projected once, and a new landscape needs transfers
 * only. Noise and lost points spoil the demonstrator's images alone.
 * @import {World} from "./world.js" */
import {scatter} from "./affine.js";
import {clamp} from "./algebra.js";
import {MIN_POINTS} from "./session.js";
import {conflict, residual, TRANSFERS} from "./transfers.js";
import {seenTwice, select} from "./world.js";

const MAX_ROUNDS = 24, NARROWER = 4, FINEST_RAD = .002 * Math.PI / 180; // of the search for the lowest E

export class Landscape {
  /** @param {World} world of two moving joints @param {number} stepDeg */
  constructor(world, stepDeg) {
    const {lower, upper} = world.scene;
    this.world = world;
    this.stepDeg = stepDeg;
    /** Angles of each joint, rad: E is (axes[0].length x axes[1].length), row by row. */
    this.axes = lower.map((low, k) => {
      const steps = Math.round((upper[k] - low) * 180 / Math.PI / stepDeg);
      return Float64Array.from({length: steps + 1}, (_, i) => low + (upper[k] - low) * i / steps);
    });
    this.count = this.axes[0].length * this.axes[1].length;
    this.E = new Float64Array(this.count).fill(NaN);
    const size = 4 * world.body.length;
    this.images = new Float64Array(size * this.count);
    this.seen = new Uint8Array(size / 2 * this.count);
    this.projected = 0;
    this.table = {points: "", own: new Float64Array(0), scatters: new Float64Array(16 * this.count), filled: 0};
  }

  /** @param {number} posture its index in E */
  posture(posture) {
    const columns = this.axes[1].length;
    return [this.axes[0][Math.floor(posture / columns)], this.axes[1][posture % columns]];
  }

  /** Fill E, or the part of it from one posture up to another, for what the learner sees of the demonstrator.
   * @param {string} transfer @param {import("./world.js").Look} demo @param {number} [from] @param {number} [to] */
  evaluate(transfer, {images, seen}, from = 0, to = this.count) {
    const shown = seenTwice(seen), N = this.world.body.length, minPoints = Math.min(MIN_POINTS, N);
    if (shown.length < minPoints) return void this.E.fill(NaN, from, to);
    this.#project(to);
    this.#centre(shown, to);
    const energy = TRANSFERS[transfer].energies(select(images, shown));
    for (let g = from; g < to; g++) {
      const own = this.seen.subarray(2 * N * g, 2 * N * (g + 1));
      const usable = shown.every(i => own[2 * i] && own[2 * i + 1]) ? shown : shown.filter(i => own[2 * i] && own[2 * i + 1]);
      if (usable === shown) this.E[g] = energy(this.table, g);
      else this.E[g] = usable.length < minPoints ? NaN : this.#energyOfSome(transfer, images, usable, g);
    }
  }

  /** The posture with the smallest E, and E there; null where E is nowhere known. */
  get minimum() {
    let least = -1;
    for (let g = 0; g < this.count; g++) if (this.E[g] < (least < 0 ? Infinity : this.E[least])) least = g;
    return least < 0 ? null : {theta: this.posture(least), E: this.E[least]};
  }

  /** The lowest E between the grid's postures too, by a parabola; null where E is nowhere known. */
  get lowest() {
    const {minimum, axes: [first, second], E, world: {scene}} = this, step = [first[1] - first[0], second[1] - second[0]];
    return minimum && lowestNear(minimum.theta, step, theta => {
      const [i, j] = theta.map((v, k) => Math.round((v - scene.lower[k]) / step[k]));
      return E[i * second.length + j];
    }, scene);
  }

  /** @param {string} transfer @param {Float64Array} images @param {number[]} usable @param {number} g */
  #energyOfSome(transfer, images, usable, g) {
    const size = 4 * this.world.body.length, demo = select(images, usable);
    const own = select(this.images.subarray(size * g, size * (g + 1)), usable);
    return conflict(residual(TRANSFERS[transfer].fit(demo, own), demo, own));
  }

  /** Look at the learner in all postures up to one of them. @param {number} to */
  #project(to) {
    for (; this.projected < to; this.projected++) {
      const {images, seen} = this.world.look("learner", this.posture(this.projected));
      this.images.set(images, images.length * this.projected);
      this.seen.set(seen, seen.length * this.projected);
    }
  }

  /** Centre the images of these points, and sum their scatter matrices. @param {number[]} points @param {number} to */
  #centre(points, to) {
    const key = points.join(), size = 4 * points.length, all = 4 * this.world.body.length;
    if (this.table.points !== key) {
      const own = this.table.own.length === size * this.count ? this.table.own : new Float64Array(size * this.count);
      this.table = {points: key, own, scatters: this.table.scatters, filled: 0};
    }
    const {own, scatters} = this.table, mean = [0, 0, 0, 0];
    for (let g = this.table.filled; g < to; g++) {
      mean.fill(0);
      for (const i of points) for (let k = 0; k < 4; k++) mean[k] += this.images[all * g + 4 * i + k];
      points.forEach((i, n) => {
        for (let k = 0; k < 4; k++) own[size * g + 4 * n + k] = this.images[all * g + 4 * i + k] - mean[k] / points.length;
      });
      const centred = own.subarray(size * g, size * (g + 1));
      scatter(centred, centred, scatters.subarray(16 * g, 16 * g + 16));
    }
    this.table.filled = Math.max(this.table.filled, to);
  }
}

/** E of one posture, px²; NaN where too few points are seen.
 * @param {World} world @param {string} transfer @param {import("./world.js").Look} demo @param {number[]} theta */
export function energyAt(world, transfer, demo, theta) {
  const points = matched(world, demo, theta);
  return points ? conflict(residual(TRANSFERS[transfer].fit(points.demo, points.own), points.demo, points.own)) : NaN;
}

/** The images of the points that all four views show; null if these are too few.
 * @param {World} world @param {import("./world.js").Look} demo @param {number[]} theta */
export function matched(world, demo, theta) {
  const own = world.look("learner", theta), shown = seenTwice(own.seen), both = seenTwice(demo.seen).filter(i => shown.includes(i));
  return both.length < Math.min(MIN_POINTS, world.body.length) ? null
    : {demo: select(demo.images, both), own: select(own.images, both)};
}

/** The posture within the limits where a function of it is smallest, from one that is near: Newton steps on ever closer
 * postures, a step of them at most. @param {(theta: number[]) => number} of @param {number[]} theta rad
 * @param {number} step rad, of the first ones @param {{lower: number[], upper: number[]}} limits */
export function lowest(of, theta, step, limits) {
  for (let round = 0; round < MAX_ROUNDS && step > FINEST_RAD; round++) {
    const next = lowestNear(theta, [step, step], of, limits), moved = Math.max(...next.map((v, k) => Math.abs(v - theta[k])));
    theta = next;
    if (moved < .99 * step) step /= NARROWER;
  }
  return theta;
}

/** The lowest place of the paraboloid through nine postures: one Newton step, which must not lead farther than they do.
 * @param {number[]} theta rad @param {number[]} step rad, from each of the nine to the next
 * @param {(theta: number[]) => number} energyAt @param {{lower: number[], upper: number[]}} limits
 * @returns {number[]} */
function lowestNear(theta, step, energyAt, {lower, upper}) {
  const middle = theta.map((v, k) => clamp(v, lower[k] + step[k], upper[k] - step[k]));
  const at = (/** @type {number} */ i, /** @type {number} */ j) => middle.map((v, k) => v + [i, j][k] * step[k]);
  const around = [-1, 0, 1].map(i => [-1, 0, 1].map(j => energyAt(at(i, j))));
  const [[a, b, c], [d, e, f], [g, h, i]] = around;
  const slope = [(h - b) / 2, (f - d) / 2], bend = [b - 2 * e + h, d - 2 * e + f], twist = (a - c - g + i) / 4;
  const determinant = bend[0] * bend[1] - twist ** 2;
  if (bend[0] > 0 && determinant > 0) {
    const by = [(twist * slope[1] - bend[1] * slope[0]) / determinant, (twist * slope[0] - bend[0] * slope[1]) / determinant];
    return at(clamp(by[0], -1, 1), clamp(by[1], -1, 1));
  }
  const least = Math.min(...around.flat().filter(Number.isFinite)), k = around.flat().indexOf(least);
  return k < 0 ? theta : at(Math.floor(k / 3) - 1, k % 3 - 1);
}
