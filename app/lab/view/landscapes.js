/** When the map of E is computed: a quick one at once, the fine one in slices once nothing moves. */
import {clamp, conflict, Landscape, MIN_POINTS, residual, select, TRANSFERS} from "../engine/engine.js";

const FINE_DEG = 1, QUICK_DEG = 2, SLOW_QUICK_DEG = 4; // steps: at rest, in motion, in motion for slow transfers
const SLICE_MS = 7, REST_MS = 120, BLOCK = 256; // postures computed between two looks at the clock
const REFINEMENTS = 4, NARROWER = 4, DEGREE = Math.PI / 180; // of the lowest E: rounds, and by how much each is narrower

/** @import {Look} from "../engine/world.js" */

export class Landscapes {
  /** @param {import("./map.js").EnergyMap} map @param {import("./experiment.js").Experiment} experiment
   * @param {() => void} changed when the fine one is drawn */
  constructor(map, experiment, changed) {
    this.map = map;
    this.experiment = experiment;
    this.changed = changed;
    /** By their steps, in degrees. @type {Map<number, Landscape>} */
    this.known = new Map();
    /** @type {Landscape | null} */
    this.shown = null;
    /** Where E is lowest, refined between the grid's postures. @type {number[] | null} */
    this.minimum = null;
    /** What the fine one on display was computed for. @type {{transfer: string, demo: Look} | null} */
    this.of = null;
    this.job = 0;
    this.resting = 0;
  }

  /** For what the learner now sees of the demonstrator. */
  update() {
    if (this.#isFine()) return;
    this.job++;
    this.of = null;
    const {transfer} = this.experiment.state, quick = this.#of(transfer === "projective" ? SLOW_QUICK_DEG : QUICK_DEG);
    quick.evaluate(transfer, this.#demo());
    this.#show(quick);
    this.minimum = lowestOfGrid(quick);
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.#refine(), REST_MS);
  }

  /** Draw it again, as its size or its colours have changed. */
  redraw() {
    if (this.shown) this.#show(this.shown);
  }

  /** The fine one in one go. */
  fine() {
    const fine = this.#of(FINE_DEG);
    fine.evaluate(this.experiment.state.transfer, this.#demo());
    this.#finish(fine);
  }

  /** Whether the fine one on display is of what the learner sees now. */
  #isFine() {
    const {of, shown, experiment: {world, state}} = this, demo = this.#demo();
    return Boolean(of && of.transfer === state.transfer && shown?.world === world
      && equal(of.demo.images, demo.images) && equal(of.demo.seen, demo.seen));
  }

  /** @param {Landscape} fine that was computed */
  #finish(fine) {
    this.of = {transfer: this.experiment.state.transfer, demo: this.#demo()};
    this.#show(fine);
    const start = lowestOfGrid(fine), energyAt = energyOf(fine.world, this.of.transfer, this.of.demo);
    this.minimum = start;
    for (let round = 0, step = FINE_DEG * DEGREE; this.minimum && round < REFINEMENTS; round++, step /= NARROWER)
      this.minimum = lowestNear(this.minimum, [step, step], energyAt, fine.world.scene);
  }

  #refine() {
    const mine = ++this.job, fine = this.#of(FINE_DEG), demo = this.#demo(), {transfer} = this.experiment.state;
    let at = 0;
    const slice = () => {
      if (mine !== this.job) return;
      const until = performance.now() + SLICE_MS;
      while (at < fine.count && performance.now() < until)
        fine.evaluate(transfer, demo, at, at = Math.min(fine.count, at + BLOCK));
      if (at < fine.count) return void setTimeout(slice);
      this.#finish(fine);
      this.changed();
    };
    slice();
  }

  #demo() {
    const {views} = this.experiment.now;
    return {images: views.demo, seen: views.demoSeen};
  }

  /** @param {number} step */
  #of(step) {
    const {world} = this.experiment, known = this.known.get(step);
    if (known?.world === world) return known;
    if (known) this.known.clear();
    const made = new Landscape(world, step);
    this.known.set(step, made);
    return made;
  }

  /** @param {Landscape} landscape */
  #show(landscape) {
    const {lower, upper, names} = this.experiment.scene;
    this.shown = landscape;
    this.map.ground(landscape, {lower, upper, joints: names});
  }
}

/** Whether two lists hold the same. @param {ArrayLike<number>} a @param {ArrayLike<number>} b */
function equal(a, b) {
  if (a.length !== b.length) return false;
  for (let k = 0; k < a.length; k++) if (a[k] !== b[k]) return false;
  return true;
}

/** E at any posture, NaN where it is not known.
 * @param {import("../engine/world.js").World} world @param {string} transfer @param {Look} demo
 * @returns {(theta: number[]) => number} px² */
const energyOf = (world, transfer, demo) => theta => {
  const {images, seen} = world.look("learner", theta), usable = [];
  for (let i = 0; i < images.length / 4; i++)
    if ([2 * i, 2 * i + 1].every(at => demo.seen[at] && seen[at])) usable.push(i);
  if (usable.length < MIN_POINTS) return NaN;
  const [of, own] = [select(demo.images, usable), select(images, usable)];
  return conflict(residual(TRANSFERS[transfer].fit(of, own), of, own));
};

/** The lowest E of a grid, refined by a parabola through its neighbours. @param {Landscape} landscape */
function lowestOfGrid(landscape) {
  const {minimum, axes: [first, second], E, world: {scene}} = landscape;
  if (!minimum) return null;
  const step = [first[1] - first[0], second[1] - second[0]], columns = second.length;
  return lowestNear(minimum.theta, step, theta => {
    const [i, j] = theta.map((v, k) => Math.round((v - scene.lower[k]) / step[k]));
    return E[i * columns + j];
  }, scene);
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
