/** E over the range of the learner's two joints, as in Fig. 7 of the paper. It asks for images at every posture, so it
 * is for people: a servo cannot see it.
 *
 * The learner's images do not depend on the demonstrator: they are projected once, and a new landscape needs transfers
 * only. Noise and lost points spoil the demonstrator's images alone. */
import {scatter} from "./affine.js";
import {MIN_POINTS} from "./session.js";
import {conflict, residual, TRANSFERS} from "./transfers.js";
import {seenTwice, select} from "./world.js";

export class Landscape {
  /** @param {import("./world.js").World} world of two moving joints @param {number} stepDeg */
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
