/** What the lab is about: a preset with its changes, its scene, the session, and the address that says it. */
import {select, Session, World} from "../engine/engine.js";
import {beginning, fromAddress, toAddress} from "./address.js";
import {pageLink} from "./link.js";

/**
 * @typedef {import("./address.js").State} State
 * @typedef {import("../engine/session.js").Moment} Moment
 * @typedef {import("./view.js").Scene} Scene
 * @typedef {{scenes: Record<string, Scene>, presets: import("./address.js").Preset[]}} Offered
 */

export class Experiment {
  /** @param {Offered} offered @param {string} address */
  constructor(offered, address) {
    this.offered = offered;
    /** What the address says wrongly. @type {string[]} */
    this.misread = [];
    this.state = this.#read(address);
    this.scene = offered.scenes[this.preset.scene];
    this.world = new World(this.scene, this.state.points);
    this.session = new Session(this.world, this.#settings());
    this.chosen = 0;
    /** The motion at which the demonstrator moved last. */
    this.posedAt = 0;
    this.enter(this.state);
  }

  get now() {
    return this.session.now;
  }

  get preset() {
    const {presets} = this.offered;
    return presets.find(({name}) => name === this.state.preset) ?? presets[0];
  }

  /** Postures at which the preset begins, and its other fields. */
  get usual() {
    return beginning(this.preset, this.scene);
  }

  /** @param {State} state */
  enter(state) {
    this.state = state;
    this.scene = this.offered.scenes[this.preset.scene];
    if (this.world.body !== this.scene.layouts[state.points]) this.world = new World(this.scene, state.points);
    this.posedAt = 0;
    this.session = new Session(this.world, this.#settings());
    while (this.now.motion < state.steps && this.session.step());
    const {point = Infinity} = state;
    this.chosen = point < this.world.body.length ? point : farthestOff(this.now);
  }

  /** A point that stays chosen. @param {number} point */
  choose(point) {
    this.state.point = this.chosen = point;
  }

  /** One motion back. */
  undo() {
    this.session.undo();
    this.posedAt = Math.min(this.posedAt, this.now.motion);
  }

  /** @param {string} hash */
  enterAddress(hash) {
    this.misread = [];
    this.enter(this.#read(hash));
  }

  /** The same experiment with other fields, from the start. @param {Partial<State>} changes */
  restart(changes) {
    this.misread = [];
    this.enter({...this.current(), steps: 0, ...changes});
  }

  /** The demonstrator moves. @param {number[]} theta */
  pose(theta) {
    this.session.pose(theta);
    this.posedAt = this.now.motion;
  }

  /** The learner begins again from a posture. @param {number[]} theta */
  place(theta) {
    this.#begin({demonstrator: this.now.thetaDemo, start: theta});
  }

  /** Another law begins to learn from where the run began. @param {string} servo */
  setServo(servo) {
    this.state.servo = servo;
    this.#begin({demonstrator: this.now.thetaDemo, servo});
  }

  /** First the learner goes back to its start, then both go back to the poses of the experiment. */
  reset() {
    const {demonstrator, start} = this.usual;
    if (this.now.motion) this.#begin({demonstrator: this.now.thetaDemo});
    else this.#begin({demonstrator, start});
  }

  /** Whether `reset` would change nothing. */
  get isReset() {
    const {now, usual} = this;
    return !now.motion && same(now.thetaDemo, usual.demonstrator) && same(now.theta, usual.start);
  }

  /** @returns {State} */
  current() {
    const {theta, thetaDemo: demonstrator, motion} = this.now, {start} = this.session.settings;
    // No address tells how the demonstrator has moved
    return {...this.state, demonstrator, ...this.posedAt ? {start: theta, steps: 0} : {start, steps: motion}};
  }

  address() {
    return toAddress(this.current(), this.preset, this.scene);
  }

  /** The address at which the page of viewimit opens in this state. */
  pageLink() {
    const {scene, layouts} = this.scene.page ?? {scene: "", layouts: []};
    return pageLink(this.current(), scene, layouts);
  }

  /** @param {string} hash */
  #read(hash) {
    return fromAddress(hash, this.offered.presets, this.offered.scenes, this.misread);
  }

  #settings() {
    const {transfer, servo, demonstrator, start, noisePx, missing, seed} = this.state;
    return {transfer, servo, demonstrator, start, noisePx, missing, seed};
  }

  /** @param {Partial<import("../engine/session.js").Settings>} changes */
  #begin(changes) {
    this.posedAt = 0;
    this.session.begin({...this.session.settings, ...changes});
  }
}

/** The point that shows most: with the largest residual. @param {Moment} moment */
function farthestOff({views, usable, fitted}) {
  if (!fitted) return 0;
  const own = select(views.own, usable), found = fitted.recover(select(views.demo, usable));
  const off = usable.map((_, k) => Math.hypot(...[0, 1, 2, 3].map(c => own[4 * k + c] - found[4 * k + c])));
  return usable[off.indexOf(Math.max(...off))];
}

/** Whether two postures are equal up to rounding. @param {number[]} a @param {number[]} b */
const same = (a, b) => a.every((v, k) => Math.abs(v - b[k]) < 1e-6);
