/** When the map of E is computed: a quick one at once, the fine one in slices once nothing moves. */
import {DEGREE, energyAt, Landscape, lowest} from "../engine/engine.js";

const FINE_DEG = 1, QUICK_DEG = 2, SLOW_QUICK_DEG = 4; // steps: at rest, in motion, in motion for slow transfers
const SLICE_MS = 7, REST_MS = 120, BLOCK = 256; // postures computed between two looks at the clock

/** @import {Look} from "../engine/world.js" @import {EnergyMap} from "./map.js" @import {Experiment} from "./experiment.js" */

export class Landscapes {
  /** @param {EnergyMap} map @param {Experiment} experiment @param {() => void} changed when the fine one is drawn */
  constructor(map, experiment, changed) {
    this.map = map;
    this.experiment = experiment;
    this.changed = changed;
    this.known = /** @type {Map<number, Landscape>} */ (new Map()); // by their steps, in degrees
    this.shown = /** @type {Landscape | null} */ (null);
    this.minimum = /** @type {number[] | null} */ (null); // where E is lowest, refined between the grid's postures
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
    this.minimum = quick.lowest;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.#refine(), REST_MS);
  }

  /** Draw it again, as its size or its colours have changed. */
  redraw() { if (this.shown) this.#show(this.shown); }

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
      && `${of.demo.images} ${of.demo.seen}` === `${demo.images} ${demo.seen}`);
  }

  /** @param {Landscape} fine that was computed */
  #finish(fine) {
    this.of = {transfer: this.experiment.state.transfer, demo: this.#demo()};
    this.#show(fine);
    const {transfer, demo} = this.of, {world, minimum} = fine;
    this.minimum = minimum && lowest(theta => energyAt(world, transfer, demo, theta), minimum.theta, FINE_DEG * DEGREE, world.scene);
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
