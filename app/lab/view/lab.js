/** The lab: an experiment, its view, and what happens when either changes. The method itself is in ../engine. */
import {geometry, MIN_POINTS, recovered} from "../engine/engine.js";
import {dragging} from "./dragging.js";
import {Experiment} from "./experiment.js";
import {Form} from "./form.js";
import {listen, press} from "./keys.js";
import {Landscapes} from "./landscapes.js";
import {byId as $, copy} from "./page.js";
import {Player} from "./playing.js";
import {Sliders} from "./sliders.js";
import {energyText, say} from "./svg.js";
import {outcome, residualText, stepsText, truth} from "./words.js";

/** @import {State} from "./address.js" @import {Offered} from "./experiment.js" @import {View} from "./view.js" @import {Moment} from "../engine/session.js" */

const MAX_PATH = 400; // postures drawn on the map
const EASE = .2, HELD_EASE = .12; // share of their way that the images' windows go in a frame
const REMEMBER_MS = 250, SAID_MS = 150, PLAYED_MS = 800; // until the address is written, and a sentence is announced

export class Lab {
  /** @param {Offered} offered @param {View} view @param {string} address */
  constructor(offered, view, address) {
    this.view = view;
    this.experiment = new Experiment(offered, address);
    this.player = new Player(this.experiment, () => this.draw(), () => this.#remember());
    this.landscapes = new Landscapes(view.map, this.experiment, () => this.redraw());
    this.isOpen = true; // whether it is on display, and not a replay
    this.isServed = /\/lab$/.test(location.pathname) && location.protocol !== "file:";
    const lesson = this.isServed ? lessonBehind(location.hash) : null;
    /** The link to the page that has all methods, which opens there in this state. @type {HTMLAnchorElement | null} */
    this.workbench = document.querySelector(".to-workbench");
    this.announced = "";
    this.announcing = this.remembering = 0;
    const hold = (/** @type {boolean} */ held) => this.hold(held);
    const {experiment} = this;
    this.sliders = {
      demo: new Sliders($("demo"), "demonstrator",
        (joint, angle) => this.pose(experiment.now.thetaDemo.map((v, k) => k === joint ? angle : v)), hold),
      own: new Sliders($("own"), "learner",
        (joint, angle) => this.place(experiment.now.theta.map((v, k) => k === joint ? angle : v)), hold),
    };
    this.form = new Form(this);
    dragging(this);
    this.#buttons();
    this.#keys();
    addEventListener("popstate", () => clearTimeout(this.remembering)); // else it would write over where Back leads
    addEventListener("hashchange", () => {
      if (this.isOpen) this.#entered(() => this.experiment.enterAddress(location.hash), true);
    });
    this.#entered(() => {}, this.isServed || this.experiment.misread.length > 0);
    this.draw();
    if (!address && !location.hash) this.player.nod();
    $("lesson").hidden = !lesson;
    if (lesson) $("lesson").href = lesson;
  }

  // What changes the experiment

  /** @param {State} state */
  enter(state) {
    const isOther = state.preset !== this.experiment.state.preset;
    if (isOther) this.#write("replaceState");
    this.player.play(false);
    this.experiment.misread = [];
    this.#entered(() => this.experiment.enter(state), true);
    if (isOther) this.#write("pushState"); // the browser's Back leads to the preset before
  }

  /** Be on display again. */
  open() { this.isOpen = true; }

  /** Leave the display to a replay. */
  close() {
    this.player.play(false);
    this.isOpen = false;
    clearTimeout(this.landscapes.resting);
  }

  /** The same experiment with other fields, from the start. @param {Partial<State>} changes */
  restart(changes) { this.#entered(() => this.experiment.restart(changes), true); }

  /** @param {number[]} theta of the demonstrator */
  pose(theta) {
    this.experiment.pose(theta);
    this.landscapes.update();
    if (this.player.isPlaying) this.player.wake();
    this.redraw();
    this.#remember();
  }

  /** @param {number[]} theta of the learner, which begins again there */
  place(theta) {
    this.experiment.place(theta);
    this.player.interrupt();
    this.#remember();
  }

  /** @param {string} servo */
  setServo(servo) {
    this.experiment.setServo(servo);
    this.form.fill();
    this.player.interrupt();
    this.#remember();
  }

  reset() {
    this.player.play(false);
    this.experiment.reset();
    this.player.interrupt();
    this.landscapes.update();
    this.#remember();
  }

  play() { if (!$("play").disabled) this.player.play(!this.player.isPlaying); }

  step() { if (!$("step").disabled) this.player.step(); }

  undo() {
    this.player.undo();
    this.#remember();
  }

  /** @param {number} point */
  choose(point) {
    if (point >= this.experiment.world.body.length) return;
    this.experiment.choose(point);
    this.redraw();
    this.#remember();
  }

  /** Something is dragged, or released. @param {boolean} held */
  hold(held) { this.player.isHeld = held; }

  /** Enter an experiment, and show it from its beginning.
   * @param {() => void} enter @param {boolean} isNew whether the address has to follow */
  #entered(enter, isNew) {
    enter();
    const {scene} = this.experiment;
    this.view.setScene(scene);
    for (const each of Object.values(this.sliders)) each.build(scene.names, scene.lower, scene.upper);
    this.player.interrupt();
    this.form.fill();
    this.landscapes.update();
    if (isNew) this.#remember();
  }

  // Drawing

  redraw() { if (this.isOpen) this.player.redraw(); }

  /** A size or the colours have changed. */
  resized() {
    this.landscapes.redraw();
    this.redraw();
  }

  draw() {
    if (!this.isOpen) return;
    const {experiment, view, player, sliders} = this, {now, world, scene, session, state, chosen} = experiment;
    const moment = player.shown(), {views, theta, thetaDemo} = moment, goal = $("goal").checked;
    const at = (/** @type {Float64Array} */ of) => of.subarray(4 * chosen, 4 * chosen + 4);
    const crosses = state.transfer === "epipolar" && moment.usable.includes(chosen);
    const lines = crosses ? geometry(moment)?.lines(at(views.demo), at(views.own)) ?? [] : [];
    const ease = player.still.matches ? 1 : player.isHeld ? HELD_EASE : EASE;
    const rays = $("rays").checked, shown = {moment, recovered: recovered(moment), lines, chosen, goal, ease, rays, isChosen: state.point !== undefined};
    const moves = view.draw(world, shown);
    const visited = session.trace.slice(0, player.glide ? -1 : undefined), {posedAt} = experiment;
    const path = visited.map((one, k) =>
      ({theta: one.theta, probe: Boolean(session.trace[k + 1]?.probe), isPast: one.motion < posedAt})).slice(-MAX_PATH);
    const hasMinimum = world.body.length >= MIN_POINTS && moment.fitted && goal;
    const minimum = hasMinimum ? this.landscapes.minimum : null;
    view.map.marks({demonstrator: goal ? thetaDemo : null, learner: theta, minimum, path});
    view.curve.draw(session.trace);
    say($("E"), energyText(moment.E));
    say($("typical"), moment.fitted ? residualText(moment.E) : "–");
    $("fit").hidden = !view.space?.isTurned();
    $("map").classList.toggle("blank", !moment.fitted);
    document.body.classList.toggle("goalless", !goal);
    document.body.classList.toggle("lineless", state.transfer !== "epipolar");
    $("draw-of-noise").hidden = !state.noisePx;
    sliders.demo.show(thetaDemo, thetaDemo);
    sliders.own.show(theta, thetaDemo);
    const said = outcome(now, player.isPlaying, world.body.length, posedAt), words = `${said.label}. ${said.text}`;
    $("state").className = `state ${said.dot}`;
    say($("outcome"), `${said.label}.`);
    say($("sentence"), ` ${said.text}`);
    if (words !== this.announced) this.#announce(words);
    const hidden = "The goal is hidden, from you as from the learner.";
    say($("truth"), goal ? truth(theta, thetaDemo, scene.names, moment.E) : hidden);
    this.#count(now);
    if (moves && !player.isTicking) this.redraw();
  }

  /** How many steps and points there are, and what can be done next. @param {Moment} now */
  #count(now) {
    const {player, experiment: {world}} = this, used = now.usable.length, all = world.body.length;
    say($("count"), stepsText(now.motion));
    say($("used"), used < all ? `${used} of ${all} points seen in all four` : "");
    say($("play").querySelector("b"), player.isFollowing ? "Following" : player.isPlaying ? "Pause" : "Play");
    $("play").disabled = all < MIN_POINTS;
    $("step").disabled = all < MIN_POINTS || player.isAtRest;
    $("undo").disabled = !now.motion;
    $("reset").disabled = this.experiment.isReset;
  }

  /** A screen reader hears the sentence once it stays the same for a while. @param {string} text */
  #announce(text) {
    const {isPlaying, isFollowing} = this.player;
    this.announced = text;
    clearTimeout(this.announcing);
    this.announcing = setTimeout(
      () => say($("announced"), `${text} ${$("truth").textContent}`), isPlaying && !isFollowing ? PLAYED_MS : SAID_MS);
  }

  /** Write the state into the address. */
  #remember() {
    clearTimeout(this.remembering);
    this.remembering = setTimeout(() => this.#write("replaceState"), REMEMBER_MS);
  }

  /** @param {"replaceState" | "pushState"} how */
  #write(how) {
    clearTimeout(this.remembering);
    if (!this.isOpen) return;
    if (this.workbench) this.workbench.href = `./?${this.experiment.pageLink()}`;
    try { history[how](null, "", this.experiment.address()); } catch { /* a frame without an address */ }
  }

  /** Copy what opens elsewhere: of a page that is a file, what stands behind the file's address. */
  #copyLink() {
    const state = this.experiment.address(), hasAddress = location.protocol.startsWith("http");
    if (!hasAddress) say($("says"),
      "This page is a file, so no link opens it elsewhere. Send the file, and add what was copied to its address.");
    void copy($("link"), hasAddress ? location.href.split("#")[0] + state : state, "The link to this:");
  }

  #buttons() {
    press({
      play: () => this.play(), step: () => this.step(),
      undo: () => this.undo(), reset: () => this.reset(),
      help: () => $("keys").showModal(), fit: () => this.view.space?.fit(), scheme: () => this.view.recolour(this),
      link: () => this.#copyLink(),
    }, () => this.isOpen);
  }

  #keys() {
    const {form, experiment} = this;
    /** @type {Record<string, () => void>} */
    const keys = {
      " ": () => this.play(), ArrowRight: () => this.step(), ArrowLeft: () => this.undo(),
      r: () => this.reset(), g: () => form.toggle("goal"), p: () => form.nextPreset(), v: () => this.view.space?.fit(),
      n: () => this.choose((experiment.chosen + 1) % experiment.world.body.length),
      d: () => this.view.recolour(this), "?": () => $("keys").showModal(),
    };
    for (let digit = 0; digit < 10; digit++) keys[digit] = () => this.choose(digit);
    listen(keys, () => this.isOpen);
  }
}

/** The address of the step from which a lesson has opened the lab. @param {string} hash @returns {string | null} */
const lessonBehind = hash => {
  const back = new URLSearchParams(hash.slice(1)).get("back") ?? "";
  return /^[\w-]+#[\w=&-]*$/.test(back) ? `lab/${back}` : null;
};
