/** A replay: the lab's view of a recorded run, a time bar under it, and the way into the lab from any of its snapshots.

 * @import {Run} from "./recorded.js" @import {State} from "./address.js" @import {View, Scene} from "./view.js" */
import {World} from "../engine/engine.js";
import {Angles} from "./curve.js";
import {listen, press} from "./keys.js";
import {byId as $, copy, perFrame} from "./page.js";
import {Recorded} from "./recorded.js";
import {Sliders} from "./sliders.js";
import {energyText, fixed, say, smoothstep} from "./svg.js";
import {residualText, SERVO_WORDS, TRANSFER_WORDS, verdicts} from "./words.js";

const GLIDE = 0.75; // share of a motion's time in which the arm moves
/** Motions a second, of runs of more motions than these. */
const SPEEDS = /** @type {const} */ ([[200, "25"], [60, "10"], [24, "4"], [-1, "2"]]);
const LEAP = 10; // motions by Page Up and Page Down

export class Replay {
  /** @param {Run} run @param {Scene} scene @param {View} view
   * @param {((state: Partial<State>, says: string) => void) | null} takeOver opens the lab */
  constructor(run, scene, view, takeOver) {
    this.scene = scene;
    this.view = view;
    this.takeOver = takeOver;
    this.recorded = new Recorded(run, scene);
    this.world = new World(scene);
    this.angles = new Angles($("angles"));
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.redraw = perFrame(() => this.draw());
    this.isOpen = false;
    this.isPlaying = false;
    this.shown = this.now = this.since = 0;
    this.last = run.snapshots.length - 1;
    this.chosen = run.chosen ?? 0;
    const motions = run.snapshots[this.last].motion;
    $("time").max = this.last;
    $("speed").value = SPEEDS.find(([most]) => motions > most)?.[1] ?? "2";
    this.sliders = new Sliders($("own"), "learner", () => {}, () => {});
    $("takeover").hidden = !takeOver;
    this.#controls();
    this.#keys();
    this.#scrub(this.view.curve, $("curve"));
    this.#scrub(this.angles, $("angles"));
    new ResizeObserver(() => { this.angles.measure(); this.redraw(); }).observe($("angles"));
  }

  get moment() { return this.recorded.snapshots[this.now]; }

  /** Show it, from a motion on. @param {number} motion */
  open(motion) {
    const {names, lower, upper} = this.scene;
    this.isOpen = true;
    document.body.classList.remove("lineless");
    document.body.classList.add("replay");
    this.view.setScene(this.scene);
    this.sliders.build(names, lower, upper);
    this.sliders.lock();
    this.shown = -1;
    this.show(this.#nearest(motion));
  }

  close() {
    this.play(false);
    this.isOpen = false;
    document.body.classList.remove("replay", "unmapped", "stepwise");
    $("map").hidden = false;
  }

  /** @param {number} k index of a moment */
  show(k) {
    this.now = Math.max(0, Math.min(this.last, k));
    const {motion} = this.moment, words = `${motion} of ${this.recorded.snapshots[this.last].motion}`;
    $("time").value = this.now;
    $("time").style.setProperty("--at", `${100 * this.now / Math.max(1, this.last)}%`);
    $("time").setAttribute("aria-valuetext", `after ${words} steps`);
    $("where").value = words;
    this.redraw();
  }

  /** @param {number} k */
  jump(k) {
    this.play(false);
    this.show(k);
  }

  /** @param {boolean} on */
  play(on) {
    if (on === this.isPlaying) return;
    this.isPlaying = on;
    this.since = 0;
    document.body.classList.toggle("playing", on);
    $("run").setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) return void this.redraw();
    if (this.now === this.last) this.show(0);
    requestAnimationFrame(at => this.#tick(at));
  }

  /** A size or the colours have changed. */
  resized() {
    this.shown = -1;
    this.redraw();
  }

  draw() {
    if (!this.isOpen) return;
    const {view, moment, now, chosen, recorded, scene} = this, {run, snapshots} = recorded, goal = $("goal").checked;
    view.draw(this.world, {
      moment, recovered: moment.recovered, bones: moment.bones, lines: recorded.lines(now, chosen),
      construction: recorded.construction(now, chosen), chosen, goal, ease: 1, rays: $("rays").checked,
    });
    this.#map();
    const map = run.maps[run.snapshots[now].map];
    view.curve.draw(snapshots, now, goal ? map.E_true ?? null : null);
    this.angles.draw(snapshots, now, scene.joints);
    this.sliders.show(moment.theta, moment.thetaDemo);
    document.body.classList.toggle("goalless", !goal);
    document.body.classList.toggle("stepwise", !run.methods[run.snapshots[now].method].crosses);
    this.#say();
  }

  /** The arm on its way to the next moment. @param {number} share of the way */
  #glide(share) {
    const {moment, recorded, chosen, now} = this, {theta} = recorded.snapshots[Math.min(now + 1, this.last)];
    const eased = smoothstep(share), between = moment.theta.map((v, k) => v + eased * (theta[k] - v));
    this.view.drawSpace(this.world, {
      moment: {...moment, theta: between}, recovered: moment.recovered, lines: recorded.lines(now, chosen),
      chosen, goal: $("goal").checked, ease: 1, rays: $("rays").checked,
    });
  }

  #map() {
    const {view, moment, now, recorded: {run, maps, snapshots}} = this, k = run.snapshots[now].map, ground = maps[k];
    const {bars, says} = run.maps[k], {lower, upper, names} = this.scene, goal = $("goal").checked;
    $("map").hidden = !ground;
    $("bars").hidden = Boolean(ground);
    document.body.classList.toggle("unmapped", !ground);
    if (this.shown !== k) {
      if (ground) view.map.ground(ground, {lower, upper, joints: names});
      else if (bars) $("bars").innerHTML = bars;
      else say($("bars"), says ?? "");
      this.shown = k;
    }
    if (!ground) return;
    const path = snapshots.slice(0, now).map(({theta, motion}, at) =>
      ({theta, probe: snapshots[at + 1].probe, isPast: run.snapshots[at].map !== k && motion < moment.motion}));
    view.map.marks({
      demonstrator: goal ? moment.thetaDemo : null, learner: moment.theta, path,
      minimum: goal ? ground.minimum?.theta ?? null : null, later: snapshots.slice(now + 1).map(({theta}) => theta),
      demonstrators: snapshots.slice(0, now).map(({thetaDemo}) => thetaDemo)
        .filter((theta, at, all) => !at || theta.some((v, j) => v !== all[at - 1][j])),
    });
  }

  /** What the learner says, the truth, and the numbers of the snapshot. */
  #say() {
    const {moment, now, chosen, recorded} = this, {run} = recorded, one = run.snapshots[now];
    const method = run.methods[one.method];
    $("state").className = `state ${verdicts[one.state]?.dot ?? "none"}`;
    say($("outcome"), one.title);
    say($("sentence"), ` · ${one.sentence}${one.doubt ? ` ${one.doubt}` : ""}`);
    $("word").hidden = !one.word;
    $("word").setAttribute("popovertarget", `vi-word-${one.word}`);
    $("word").setAttribute("aria-label", `What is ${one.title}?`);
    const hidden = `Hidden from the learner: ${one.truth[0].toLowerCase()}${one.truth.slice(1)}`;
    say($("truth"), $("goal").checked ? hidden : "The goal is hidden, from you as from the learner.");
    say($("E"), energyText(moment.E));
    const isKnown = Number.isFinite(moment.E), {usable, views: {own}, recovered} = moment;
    say($("typical"), isKnown ? residualText(moment.E) : "–");
    say($("by-servo"), method.servoTitle);
    say($("by-transfer"), method.transferTitle + (method.rectified ? ", of rectified images" : ""));
    const lengths = usable.flatMap(i => [0, 2].map(k => ({
      i, px: Math.hypot(recovered[4 * i + k] - own[4 * i + k], recovered[4 * i + k + 1] - own[4 * i + k + 1]),
    }))).filter(({px}) => Number.isFinite(px));
    const most = lengths.reduce((a, b) => b.px > a.px ? b : a, {i: 0, px: -1});
    say($("largest"), lengths.length ? `${fixed(most.px)} px, of point ${most.i}` : "–");
    const {condition} = one;
    say($("condition-name"), condition?.name ?? "Condition");
    say($("condition"), condition?.value ?? "–");
    $("condition").className = condition?.level ?? "";
    say($("seen"), `${usable.length} of ${own.length / 4}`);
    say($("how"), run.chosen === null && !usable.length ? "" : recorded.how(now, chosen));
  }

  /** @param {number} at ms */
  #tick(at) {
    if (!this.isPlaying) return;
    const period = 1000 / Number($("speed").value);
    if (!this.since) this.since = at;
    let isNew = false;
    while (at - this.since >= period && this.now < this.last) {
      this.since += period;
      this.now++;
      isNew = true;
    }
    if (isNew) this.show(this.now);
    if (this.now === this.last) return void this.play(false);
    if (!this.still.matches && !isNew) this.#glide(Math.min(1, (at - this.since) / (GLIDE * period)));
    requestAnimationFrame(later => this.#tick(later));
  }

  /** The index of the moment nearest to a motion. @param {number} motion */
  #nearest(motion) {
    const {snapshots} = this.recorded;
    return snapshots.reduce((best, one, k) =>
      Math.abs(one.motion - motion) < Math.abs(snapshots[best].motion - motion) ? k : best, 0);
  }

  /** @param {number} point */
  choose(point) {
    if (point < 0 || point >= this.moment.views.own.length / 4) return;
    this.chosen = point;
    this.redraw();
  }

  /** Go on in the lab from here. */
  #takeOver() {
    const {moment, recorded: {run}} = this, {lab, lacks} = run.methods[run.snapshots[this.now].method];
    const from = `The replay goes on here after step ${moment.motion}.`;
    const [servo, transfer] = [SERVO_WORDS[lab.servo].title, TRANSFER_WORDS[lab.transfer].title.toLowerCase()];
    const now = `: now it is “${servo}” and the ${transfer} transfer`;
    const instead = lacks.length ? ` The lab does not have ${listed(lacks)}${now}.` : "";
    this.takeOver?.({...lab, demonstrator: moment.thetaDemo, start: moment.theta, steps: 0}, from + instead);
  }

  /** A curve is a slider, too. @param {{motionAt: (pointer: PointerEvent) => number}} plot @param {HTMLElement} box */
  #scrub(plot, box) {
    const follow = (/** @type {PointerEvent} */ event) => {
      const nearest = this.#nearest(plot.motionAt(event));
      if (nearest !== this.now) this.jump(nearest);
    };
    box.addEventListener("pointerdown", event => {
      if (!this.isOpen) return;
      box.setPointerCapture(event.pointerId);
      follow(event);
    });
    box.addEventListener("pointermove", event => { if (this.isOpen && event.buttons) follow(event); });
  }

  #controls() {
    press({
      run: () => this.play(!this.isPlaying),
      back: () => this.jump(this.now - 1), forward: () => this.jump(this.now + 1),
      scheme: () => this.view.recolour(this), fit: () => this.view.space?.fit(), takeover: () => this.#takeOver(),
    }, () => this.isOpen);
    $("time").addEventListener("input", () => this.jump(Number($("time").value)));
    for (const id of ["goal", "rays"]) $(id).addEventListener("change", () => this.redraw());
    $("images").addEventListener("click", (/** @type {PointerEvent} */ event) => {
      const hit = this.isOpen ? this.view.images.hit(event, this.moment) : null;
      if (hit) this.choose(hit.point);
    });
    for (const button of document.querySelectorAll("button.copy")) button.addEventListener("click", () =>
      void copy(/** @type {HTMLElement} */ (button), button.nextElementSibling?.textContent ?? "", "To copy:"));
  }

  #keys() {
    const toggle = (/** @type {string} */ id) => { $(id).checked = !$(id).checked; this.redraw(); };
    const faster = (/** @type {number} */ by) => {
      const {length, selectedIndex} = $("speed");
      $("speed").selectedIndex = Math.max(0, Math.min(length - 1, selectedIndex + by));
    };
    /** @type {Record<string, () => void>} */
    const keys = {
      " ": () => this.play(!this.isPlaying),
      ArrowLeft: () => this.jump(this.now - 1), ArrowRight: () => this.jump(this.now + 1),
      Home: () => this.jump(0), End: () => this.jump(this.last), "+": () => faster(1), "-": () => faster(-1),
      PageUp: () => this.jump(this.now - LEAP), PageDown: () => this.jump(this.now + LEAP),
      d: () => this.view.recolour(this), v: () => this.view.space?.fit(), r: () => toggle("rays"), g: () => toggle("goal"),
      n: () => this.choose((this.chosen + 1) % (this.moment.views.own.length / 4)),
    };
    if (this.takeOver) keys.t = () => this.#takeOver();
    for (let digit = 0; digit < 10; digit++) keys[digit] = () => this.choose(digit);
    listen(keys, () => this.isOpen);
  }
}

/** @param {string[]} words */
const listed = words =>
  words.length < 2 ? words.join() : `${words.slice(0, -1).join(", ")} and ${words[words.length - 1]}`;
