/** Playing: while it is on, a learner at rest wakes when the demonstrator moves.
 * @import {Experiment} from "./experiment.js" @import {Moment} from "../engine/session.js" */
import {perFrame} from "./page.js";
import {smoothstep} from "./svg.js";
import {SERVO_WORDS} from "./words.js";

const PROBE_MS = 1100; // of a test move
const MAX_BEHIND_MS = 400, ADVANCE_MS = 10; // that slow drawing puts steps off for, and that steps take in a frame
const GLIDE = 0.75, MIN_GLIDE_MS = 100; // share of a period in which the arm moves
const NOD_WAIT_MS = 900, NOD_MS = 1500, NOD_RAD = .16;
const HELD = .25; // share of a period while something is dragged

export class Player {
  /** @param {Experiment} experiment @param {() => void} draw a frame @param {() => void} stepped */
  constructor(experiment, draw, stepped) {
    this.experiment = experiment;
    this.drawNow = draw;
    this.stepped = stepped;
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.redraw = perFrame(() => { if (!this.isTicking) this.drawNow(); });
    this.isPlaying = false;
    this.isHeld = false;
    this.isAsleep = false; // playing, but the servo has no motion to make
    this.isTicking = false;
    this.due = 0;
    this.glide = /** @type {{from: number[], began: number, lasts: number} | null} */ (null);
    this.nodsAt = 0; // when the demonstrator begins to nod; 0 once it has
    this.restedAt = /** @type {Moment | null} */ (null); // at which the servo had no motion to make
  }

  get isFollowing() { return this.isPlaying && this.isAsleep; }

  get isAtRest() {
    const {now} = this.experiment;
    return now === this.restedAt && Boolean(now.fitted);
  }

  /** @param {boolean} on */
  play(on) {
    this.isPlaying = on;
    document.body.classList.toggle("playing", on);
    if (on) this.wake();
    this.redraw();
  }

  /** Go on, if it is playing. */
  wake() {
    this.isAsleep = false;
    this.due = Math.max(this.due, performance.now());
    if (this.isTicking) return;
    this.isTicking = true;
    requestAnimationFrame(now => this.#tick(now));
  }

  /** The demonstrator nods once on the page, so that it is seen what its sliders move. The experiment has no part in it. */
  nod() {
    if (this.still.matches) return;
    this.nodsAt = performance.now() + NOD_WAIT_MS;
    addEventListener("pointerdown", () => { this.nodsAt = 0; }, {once: true, capture: true});
    this.wake();
  }

  /** Something else is shown from here. */
  interrupt() {
    this.nodsAt = 0;
    this.glide = null;
    if (this.isPlaying) this.wake();
    this.redraw();
  }

  step() {
    this.play(false);
    this.glide = null;
    if (this.#advance()) this.wake();
    this.redraw();
  }

  undo() {
    this.play(false);
    this.glide = null;
    this.experiment.undo();
    this.redraw();
  }

  /** The moment on display: the present one, or one on the way there. */
  shown() {
    const {now, session} = this.experiment, nodded = (performance.now() - this.nodsAt) / NOD_MS;
    if (this.nodsAt && nodded > 0 && nodded < 1) {
      const by = NOD_RAD * Math.sin(2 * Math.PI * nodded);
      return session.observe(now.theta, now.thetaDemo.map((v, k) => k ? v + by : v - by / 2));
    }
    if (!this.glide) return now;
    const {from, began, lasts} = this.glide, share = Math.min(1, (performance.now() - began) / lasts);
    const eased = smoothstep(share);
    return session.observe(now.theta.map((v, k) => from[k] + eased * (v - from[k])));
  }

  #advance() {
    const {session, state} = this.experiment, from = session.now.theta;
    if (!session.step()) {
      this.restedAt = session.now;
      return false;
    }
    const usual = session.now.probe ? PROBE_MS : SERVO_WORDS[state.servo].periodMs;
    const period = usual * (this.isHeld ? HELD : 1), now = performance.now(), isQuick = usual < MIN_GLIDE_MS;
    this.glide = this.still.matches || period < MIN_GLIDE_MS ? null : {from, began: now, lasts: GLIDE * period};
    this.due = (isQuick ? Math.max(this.due, now - MAX_BEHIND_MS) : now) + period;
    this.stepped();
    return true;
  }

  /** @param {number} now */
  #tick(now) {
    if (this.glide && now - this.glide.began >= this.glide.lasts) this.glide = null;
    if (this.isPlaying || this.isHeld || this.experiment.now.motion || now > this.nodsAt + NOD_MS) this.nodsAt = 0;
    const until = performance.now() + ADVANCE_MS;
    while (this.isPlaying && !this.isAsleep && !this.glide && now >= this.due && performance.now() < until)
      if (!this.#advance()) {
        this.isAsleep = true;
        if (!this.experiment.now.fitted) this.play(false);
      }
    this.drawNow();
    if (this.nodsAt || this.glide || this.isPlaying && !this.isAsleep) requestAnimationFrame(later => this.#tick(later));
    else this.isTicking = false;
  }
}
