/** What the lab is about: a preset with its changes, its scene, the session, and the address that says it.
 * @import {State, Preset} from "./address.js" @import {Moment, Settings} from "../engine/session.js" @import {Scene} from "./view.js"
 * @typedef {{scenes: Record<string, Scene>, presets: Preset[]}} Offered */
import {DEGREE, select, Session, World} from "../engine/engine.js";
import {beginning, fromAddress, pageLink, toAddress} from "./address.js";


export class Experiment {
  /** @param {Offered} offered @param {string} address */
  constructor(offered, address) {
    this.offered = offered;
    this.misread = /** @type {string[]} */ ([]); // what the address says wrongly
    this.state = this.#read(address);
    this.scene = offered.scenes[this.preset.scene];
    this.world = new World(this.scene, this.state.points);
    this.session = new Session(this.world, this.#settings());
    this.chosen = 0;
    /** How the demonstrator has moved since the first step, by the motions before. @type {{at: number, demonstrator: number[]}[]} */
    this.moves = [];
    this.beganAt = this.now.thetaDemo; // the demonstrator's pose before these
    this.enter(this.state);
  }

  get now() { return this.session.now; }

  get preset() {
    const {presets} = this.offered;
    return presets.find(({name}) => name === this.state.preset) ?? presets[0];
  }

  /** Postures at which the preset begins, and its other fields. */
  get usual() { return beginning(this.preset, this.scene); }

  /** @param {State} state */
  enter(state) {
    this.state = state;
    this.scene = this.offered.scenes[this.preset.scene];
    if (this.world.body !== this.scene.layouts[state.points]) this.world = new World(this.scene, state.points);
    this.moves = [];
    this.session = new Session(this.world, this.#settings());
    this.#run(state.steps);
    for (const move of state.later ?? []) {
      this.pose(move.demonstrator);
      this.#run(move.steps);
    }
    const {point = Infinity} = state;
    this.chosen = point < this.world.body.length ? point : farthestOff(this.now);
  }

  /** A point that stays chosen. @param {number} point */
  choose(point) { this.state.point = this.chosen = point; }

  /** One motion back. */
  undo() {
    this.session.undo();
    this.moves = this.moves.filter(({at}) => at <= this.now.motion);
  }

  /** @param {string} hash */
  enterAddress(hash) {
    this.misread = [];
    this.enter(this.#read(hash));
  }

  /** The same experiment with other fields, from the start. @param {Partial<State>} changes */
  restart(changes) {
    this.misread = [];
    this.enter({...this.current(), ...changes});
  }

  /** The demonstrator moves. @param {number[]} theta */
  pose(theta) {
    const demonstrator = snapped(theta), at = this.now.motion;
    if (at && !this.moves.length) this.beganAt = this.now.thetaDemo;
    this.session.pose(demonstrator);
    if (at) this.moves = [...this.moves.filter(move => move.at < at), {at, demonstrator}];
  }

  /** The learner begins again from a posture. @param {number[]} theta */
  place(theta) { this.#begin({demonstrator: this.now.thetaDemo, start: snapped(theta)}); }

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

  /** The motion at which the demonstrator moved last. */
  get posedAt() { return this.moves[this.moves.length - 1]?.at ?? 0; }

  /** The poses as they are, for a new beginning. @returns {State} */
  current() {
    const {theta, thetaDemo: demonstrator} = this.now, {start} = this.session.settings;
    return {...this.state, demonstrator, start: this.posedAt ? theta : start, steps: 0, later: []};
  }

  /** How it came here. @returns {State} */
  story() {
    const {moves, now: {motion, thetaDemo}} = this, {start} = this.session.settings;
    const demonstrator = moves.length ? this.beganAt : thetaDemo;
    const later = moves.map(({at, demonstrator}, k) => ({demonstrator, steps: (moves[k + 1]?.at ?? motion) - at}));
    return {...this.state, demonstrator, start, steps: moves[0]?.at ?? motion, later};
  }

  address() { return toAddress(this.story(), this.preset, this.scene); }

  /** The address at which the page of viewimit opens in this state. */
  pageLink() {
    const {scene, layouts} = this.scene.page ?? {scene: "", layouts: []};
    return pageLink(this.story(), scene, layouts);
  }

  /** @param {string} hash */
  #read(hash) { return fromAddress(hash, this.offered.presets, this.offered.scenes, this.misread); }

  #settings() {
    const {transfer, servo, demonstrator, start, noisePx, missing, seed} = this.state;
    return {transfer, servo, demonstrator, start, noisePx, missing, seed};
  }

  /** @param {number} steps */
  #run(steps) {
    const end = this.now.motion + steps;
    while (this.now.motion < end && this.session.step());
  }

  /** @param {Partial<Settings>} changes */
  #begin(changes) {
    this.moves = [];
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

/** A posture in the digits that an address has. @param {number[]} theta */
const snapped = theta => theta.map(v => Math.round(v / DEGREE * 100) / 100 * DEGREE);

/** Whether two postures are equal up to rounding. @param {number[]} a @param {number[]} b */
const same = (a, b) => a.every((v, k) => Math.abs(v - b[k]) < 1e-6);
