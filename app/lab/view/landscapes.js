/** When the map of E is computed: a quick one at once, the fine one in slices once nothing moves. */
import {Landscape} from "../engine/engine.js";

const FINE_DEG = 1, QUICK_DEG = 2, SLOW_QUICK_DEG = 4; // steps: at rest, in motion, in motion for slow transfers
const SLICE_MS = 7, REST_MS = 120, BLOCK = 256; // postures computed between two looks at the clock

export class Landscapes {
  /**
   * @param {import("./map.js").EnergyMap} map
   * @param {import("./experiment.js").Experiment} experiment
   * @param {() => void} changed when the fine one is drawn
   */
  constructor(map, experiment, changed) {
    this.map = map;
    this.experiment = experiment;
    this.changed = changed;
    /** By their steps, in degrees. @type {Map<number, Landscape>} */
    this.known = new Map();
    /** @type {Landscape | null} */
    this.shown = null;
    this.isHeld = false;
    this.job = 0;
    this.resting = 0;
  }

  /** For what the learner now sees of the demonstrator. */
  update() {
    this.job++;
    const {transfer} = this.experiment.state, quick = this.#of(transfer === "projective" ? SLOW_QUICK_DEG : QUICK_DEG);
    quick.evaluate(transfer, this.#demo());
    this.#show(quick);
    if (!this.isHeld) this.settle();
  }

  /** While something is held, only quick ones are computed. @param {boolean} held */
  hold(held) {
    this.isHeld = held;
    if (!held) this.settle();
  }

  settle() {
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
    this.#show(fine);
  }

  #refine() {
    const mine = ++this.job, fine = this.#of(FINE_DEG), demo = this.#demo(), {transfer} = this.experiment.state;
    let at = 0;
    const slice = () => {
      if (mine !== this.job || this.isHeld) return;
      const until = performance.now() + SLICE_MS;
      while (at < fine.count && performance.now() < until)
        fine.evaluate(transfer, demo, at, at = Math.min(fine.count, at + BLOCK));
      if (at < fine.count) return void setTimeout(slice);
      this.#show(fine);
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
