/** The loop of the paper, as a session that can be posed, stepped, undone and reset:
 *
 *     posture → body points → four views → transfer → recovered points → residual e → E → servo → next posture
 *
 * Every pass leaves one moment, which is never changed: pictures and texts read only that.
 * @import {Views, World} from "./world.js" @import {Fitted} from "./transfers.js" @import {ServoState, ServoStatus, Conflict} from "./servo.js"
 * @typedef {"ready" | "too-few-points" | ServoStatus} Status ready: no motion was made yet;
 * too-few-points: too few points are seen in all four images
 * @typedef {Object} Moment
 * @property {number} motion how many were made until then
 * @property {number} look how often the learner had looked at itself
 * @property {number[]} theta rad; the learner does not know it
 * @property {number[]} thetaDemo rad; the learner does not know it
 * @property {Views} views
 * @property {number[]} usable the points that all four views show
 * @property {Fitted | null} fitted null with too few usable points
 * @property {number} E px², NaN with too few usable points
 * @property {number[]} moved rad, the motion that led here
 * @property {boolean} probe whether that was made to learn from
 * @property {Status} status
 * @property {ServoState | null} servoState null before the servo was asked
 * @property {number | null} lag looks that images come late, null until a motion has shown it
 * @property {Fitted | null} frozen the transfer as it was fitted when the servo last rested at a minimum
 * @typedef {{transfer: string, servo: string, demonstrator: number[], start: number[], noisePx?: number, missing?:
 * number, seed?: number}} Settings transfer: of TRANSFERS; servo: of SERVOS; demonstrator: rad; start: rad; missing:
 * share of points that an image does not show */
import {EpipolarGeometry} from "./affine.js";
import {clamp, DEGREE} from "./algebra.js";
import {mirrorFinder} from "./handedness.js";
import {SERVOS} from "./servo.js";
import {conflict as energyOf, residual, TRANSFERS} from "./transfers.js";
import {MAX_LOOKS_WAITED, Observer, seenTwice, select} from "./world.js";

export const MIN_POINTS = 5; // with four, any images fit: E would be 0 everywhere
const MAX_HISTORY = 200, MAX_TRACE = 3000; // snapshots that can be undone; postures and E that are remembered

export class Session {
  /** @param {World} world @param {Settings} settings */
  constructor(world, settings) {
    this.world = world;
    this.minPoints = Math.min(MIN_POINTS, world.body.length); // a body of four points shows what becomes of E then
    this.settings = this.#complete(settings);
    this.observer = this.#observer();
    this.history = [this.#first()];
    /** Postures and E of all snapshots, longer than the history. @type {{motion: number, theta: number[], E: number, probe: boolean}[]} */
    this.trace = [traced(this.now)];
  }

  /** Begin again, at motion 0. @param {Settings} settings */
  begin(settings) { Object.assign(this, new Session(this.world, settings)); }

  get now() { return this.history[this.history.length - 1]; }

  /** Ask the servo, move, look. False if the servo rests, or the arm must hold still. */
  step() {
    if (!this.now.fitted) this.#lookAgain();
    const now = this.now;
    if (!now.fitted) return false;
    const seen = this.#observation(now), servo = SERVOS[this.settings.servo];
    const [servoState, displacement] = servo.step(now.servoState ?? servo.start(seen), seen, this.#predictedConflict(now));
    if (displacement.every(v => v === 0)) {
      const status = servoState.status === "moving" ? "no-progress" : servoState.status;
      this.#replace({...now, servoState, status, frozen: status === "settled" ? now.fitted : now.frozen});
      return false;
    }
    const {lower, upper} = this.world.scene, theta = now.theta.map((v, k) => clamp(v + displacement[k], lower[k], upper[k]));
    const before = {images: now.views.own, seen: now.views.ownSeen}, lag = now.lag ?? this.observer.lag(before, theta, now.look);
    const look = now.look + 1 + (lag ?? MAX_LOOKS_WAITED), moved = theta.map((v, k) => v - now.theta[k]);
    this.history.push(this.#observed(theta, now.thetaDemo, look,
      {...now, motion: now.motion + 1, moved, probe: servoState.probe, status: servoState.status, servoState, lag}));
    this.trace.push(traced(this.now));
    if (this.history.length > MAX_HISTORY) this.history.shift();
    if (this.trace.length > MAX_TRACE) this.trace.shift();
    return true;
  }

  /** One motion back. False at the start of the history. */
  undo() {
    if (this.history.length < 2) return false;
    this.history.pop();
    this.trace.pop();
    return true;
  }

  /** What would be seen of postures, as of now: nothing moves. @param {number[]} theta @param {number[]} [thetaDemo] */
  observe(theta, thetaDemo = this.now.thetaDemo) {
    return this.#observed(theta, thetaDemo, this.now.look, this.now);
  }

  /** Move the demonstrator, at any time: the learner looks again, and a servo at rest wakes up. @param {number[]} theta */
  pose(theta) { this.change({demonstrator: theta}); }

  /** Go on with other settings from where the arm stands. A new servo begins to learn afresh.
   * @param {Partial<Settings>} changes */
  change(changes) {
    const now = this.now, settings = {...this.settings, ...changes}, disturbed = ["noisePx", "missing", "seed"];
    const servoState = settings.servo === this.settings.servo ? now.servoState : null;
    const frozen = Object.keys(changes).every(name => name === "demonstrator") ? now.frozen : null;
    this.settings = {...settings, demonstrator: this.#rounded(settings.demonstrator)};
    if (disturbed.some(name => name in changes)) this.observer = this.#observer();
    const after = this.#observed(now.theta, this.settings.demonstrator, now.look, {...now, servoState, frozen, status: awake(now)});
    if (servoState) after.servoState = SERVOS[this.settings.servo].retarget(servoState, this.#observation(after));
    this.#replace(after);
  }

  /** @param {Settings} settings */
  #complete(settings) {
    return {...settings, demonstrator: this.#rounded(settings.demonstrator), start: this.#rounded(settings.start)};
  }

  #first() {
    const {start, demonstrator} = this.settings;
    return this.#observed(start, demonstrator, 0, {
      motion: 0, moved: start.map(() => 0), probe: false, status: "ready", servoState: null, lag: null, frozen: null,
    });
  }

  #observer() {
    const {noisePx = 0, missing = 0, seed = 7, start} = this.settings;
    return new Observer(this.world, {noisePx, missing, seed}, start);
  }

  /** As settings in degrees hold a posture, so that an address repeats a run. @param {number[]} theta */
  #rounded(theta) {
    const {lower, upper} = this.world.scene;
    return theta.map((v, k) => clamp(Math.round(v / DEGREE * 1e9) / 1e9 * DEGREE, lower[k], upper[k]));
  }

  /** posture → four views → transfer → E.
   * @param {number[]} theta @param {number[]} thetaDemo @param {number} look
   * @param {Omit<Moment, "theta" | "thetaDemo" | "look" | "views" | "usable" | "fitted" | "E">} rest
   * @returns {Moment} */
  #observed(theta, thetaDemo, look, rest) {
    const views = this.observer.views(theta, thetaDemo, look), shown = seenTwice(views.demoSeen);
    const usable = seenTwice(views.ownSeen).filter(i => shown.includes(i));
    const common = {...rest, theta, thetaDemo, look, views, usable};
    if (usable.length < this.minPoints) return {...common, fitted: null, E: NaN, status: "too-few-points"};
    const demo = select(views.demo, usable), own = select(views.own, usable);
    const fitted = TRANSFERS[this.settings.transfer].fit(demo, own);
    return {...common, fitted, E: energyOf(residual(fitted, demo, own))};
  }

  #lookAgain() {
    const now = this.now;
    this.#replace(this.#observed(now.theta, now.thetaDemo, now.look + 1, {...now, status: awake(now)}));
  }

  /** @param {Moment} moment */
  #replace(moment) {
    this.history[this.history.length - 1] = moment;
    this.trace[this.trace.length - 1] = traced(moment);
  }

  /** @param {Moment} now */
  #observation({views, E, theta, motion}) {
    const {lower, upper} = this.world.scene, {start} = this.settings, from = (/** @type {number[]} */ angles) => angles.map((v, k) => v - start[k]);
    return {own: views.own, seen: views.ownSeen, E, displacement: from(theta), lower: from(lower), upper: from(upper), motion};
  }

  /** What the servo may ask about images that it predicts. @param {Moment} now @returns {Conflict} */
  #predictedConflict({views, frozen}) {
    const drift = this.#drift(), demo = drift ? views.demo.map((v, i) => v + drift[i]) : views.demo;
    const shown = seenTwice(views.demoSeen), transfer = TRANSFERS[this.settings.transfer], {noisePx} = this.observer;
    const bodies = [[views.demo, shown], [views.own, seenTwice(views.ownSeen)]];
    const matches = Float64Array.from(bodies.flatMap(([images, points]) =>
      [...select(/** @type {Float64Array} */ (images), /** @type {number[]} */ (points))]));
    const mirrors = /** @type {Map<string, ReturnType<typeof mirrorFinder>>} */ (new Map());
    return images => {
      const known = shown.filter(i => images.every(own => own.subarray(4 * i, 4 * i + 4).every(Number.isFinite)));
      if (known.length < this.minPoints) return {residuals: images.map(() => Float64Array.of(Infinity)), count: 1};
      const target = select(demo, known), key = known.join();
      if (!mirrors.has(key)) mirrors.set(key, mirrorFinder(target, matches, noisePx));
      const mirror = mirrors.get(key);
      const found = images.map(all => {
        const own = select(all, known);
        return {e: residual(drift && noisePx && frozen || transfer.fit(target, own), target, own), mirrored: mirror?.(own)};
      });
      if (found.every(({mirrored}) => !mirrored)) return {residuals: found.map(({e}) => e), count: known.length};
      const residuals = found.map(({e, mirrored}) => Float64Array.of(...e, ...mirrored ?? new Float64Array(3 * known.length)));
      return {residuals, count: known.length};
    };
  }

  /** How far the demonstrator's points go in the next motion, if they have gone on during the last two. @returns {Float64Array | null} */
  #drift() {
    const recent = this.history.slice(-3);
    if (recent.length < 3 || recent[1].views.demo === recent[2].views.demo) return null;
    const steady = seenTwice(recent[0].views.demoSeen.map((v, i) => v & recent[1].views.demoSeen[i] & recent[2].views.demoSeen[i]));
    const last = new Float64Array(recent[0].views.demo.length);
    let along = 0;
    for (const i of steady) for (let k = 4 * i; k < 4 * i + 4; k++) {
      const [a, b, c] = recent.map(({views}) => views.demo[k]);
      last[k] = c - b;
      along += (b - a) * (c - b);
    }
    return along > 0 ? last : null;
  }
}

/** @param {Moment} moment */
const traced = ({motion, theta, E, probe}) => ({motion, theta, E, probe});

/** @param {Moment} now @returns {Status} the servo has to be asked again */
const awake = now => now.motion === 0 ? "ready" : "moving";

/** The demonstrator's points in [L], [R] as the transfer expects them: (4 N) px, NaN where not usable. @param {Moment} moment */
export function recovered({views, usable, fitted}) {
  const found = new Float64Array(views.demo.length).fill(NaN);
  if (!fitted) return found;
  const images = fitted.recover(select(views.demo, usable));
  usable.forEach((i, k) => found.set(images.subarray(4 * k, 4 * k + 4), 4 * i));
  return found;
}

/** The epipolar geometry of all six pairs of views; null with too few usable points. @param {Moment} moment */
export const geometry = ({views, usable, fitted}) =>
  fitted && new EpipolarGeometry(select(views.demo, usable), select(views.own, usable));
