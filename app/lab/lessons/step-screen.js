/** The screen of a step: its card, its figures and its sliders, and what hands do with them.
 * @import {Stage, Mark, Slider, Figure, FigureUse, FigureKind} from "./stage.js"
 * @typedef {{use: FigureUse, kind: FigureKind, box: HTMLElement, figure: Figure, isAsked:
 * boolean}} Mounted
 * @typedef {Object} Course what the page around it does
 * @property {() => boolean} isLocked
 * @property {() => boolean} isHeld whether others show the right answer
 * @property {() => void} redraw
 * @property {() => void} keep after every change that counts
 * @property {(stage: Stage) => void} answered
 * @property {(words: string) => void} note
 * @property {(words: string) => void} announce
 * @property {(seed: number) => void} restart the step
 * @property {(by: number) => void} go
 * @property {() => {counts?: number[]} | null} others
 * @property {(stage: Stage) => {href: string, words: string, of: string}[]} links to where else the step's state
 *   opens
 * @typedef {{words: string, key?: string, filled?: boolean, disabled?: boolean, act: () => void}} Button
 * @typedef {{draw: () => void, key: (event: KeyboardEvent) => boolean, primary: () => Button, skip: () => Button |
 * null, remove: () => void}} Screen key: whether it has taken the key */
import {arePlayed, isAnswered, isReached} from "./answers.js";
import {isSet} from "./asks.js";
import {Card} from "./card.js";
import {button, inline, make, touched} from "./dom.js";
import {FIGURES} from "./figures/registry.js";
import {Marks} from "./marks.js";
import {grade, measure} from "./measures.js";
import {isSteered, SlidersRow} from "./sliders-row.js";
import {solution} from "./solution.js";
import {between, Joints, play} from "../challenge/joints.js";
import {DEGREE, smoothstep} from "../view/svg.js";

const MEET_MS = 1500, MOVE_MS = 350, SOLVE_MS = 1400;
const MAX_SEED = 9999;
const FIRST = "A guess is enough: answer first. Or press “Show me” once more.";

/** @implements {Screen} */
export class StepScreen {
  /** @param {HTMLElement} body of the card @param {HTMLElement} figures @param {Stage} stage @param {Course} course */
  constructor(body, figures, stage, course) {
    const {step} = stage;
    this.stage = stage;
    this.course = course;
    this.isAsked = this.isSolving = false;
    this.stop = /** @type {(() => void) | null} */ (null); // stops the animation
    stage.changed = course.redraw;
    this.card = new Card(body, stage, {
      answered: () => this.answered(), startAgain: () => course.restart(stage.seed), isLocked: course.isLocked,
      bar: k => {
        const counts = course.others()?.counts, all = counts?.reduce((sum, count) => sum + count, 0) ?? 0;
        return counts && all ? {count: counts[k] ?? 0, share: (counts[k] ?? 0) / all} : null;
      },
    });
    this.again = body.appendChild(make("div", {class: "again"}));
    const main = make("div", {class: "main"}), side = make("div", {class: "side"}),
      row = make("div", {class: "sliders"});
    const asked = ["place", "predict"].includes(step.ask.kind) ? step.ask.figure ?? null : null;
    const boxes = [...(step.main ?? []).map(use => ({use, within: main})),
      ...(step.side ?? []).map(use => ({use, within: side}))];
    const isAsked = boxes.find(({use}) => use.figure === asked);
    this.legend = make("ul", {class: "legend"});
    figures.replaceChildren(make("div", {class: "pictures"}, main, side), row, this.legend);
    figures.dataset.main = String(step.main?.length ?? 0);
    figures.dataset.side = String(step.side?.length ?? 0);
    /** @type {Mounted[]} */
    this.mounted = boxes.flatMap(one => {
      const {use} = one, {element, box, kind} = framed(use, one === isAsked);
      one.within.append(element);
      return kind ? [{use, kind, box, isAsked: one === isAsked, figure: kind.create(box, stage)}] : [];
    });
    const own = this.mounted.find(one => one.isAsked);
    this.marks = own ? new Marks(own.box, own.figure, () => stage, mark => this.mark(mark), () => this.isOpen) : null;
    this.sliders = new SlidersRow(row, stage, (slider, value) => this.slid(slider, value), () => this.released());
    this.steered = make("div", {class: "steered"});
    row.after(this.steered);
    /** What moves the arm step by step until the goal is reached. */
    this.joints = !isSteered(stage) ? null : new Joints(this.steered, (step.sliders ?? []).map(({label, low, high}) =>
      ({name: label, low: low * DEGREE, high: high * DEGREE})), theta => this.#go(theta));
    this.sizes = new ResizeObserver(() => {
      for (const {figure} of this.mounted) figure.resize?.();
      this.reached = null;
      course.redraw();
    });
    this.mounted.forEach(({box}) => this.sizes.observe(box));
    this.body = body;
    this.figures = figures;
    this.said = "";
    this.reached = /** @type {boolean | null} */ (null); // whether it was revealed when what scrolls was looked for
  }

  /** Whether answers are taken. */
  get isOpen() { return !this.stage.isRevealed && !this.course.isLocked() && !this.stop; }

  draw() {
    const {stage, mounted} = this, drawn = new Set();
    for (const {use, figure} of mounted) {
      const layers = layersOf(use, stage);
      layers.forEach(layer => drawn.add(layer));
      try { figure.draw(stage, layers); } catch (error) { console.error(error); }
    }
    this.marks?.draw();
    this.card.update();
    this.sliders.update(this.course.isLocked());
    this.steered.hidden = !isSteered(stage) || this.isSolving;
    this.joints?.show(stage.moment.theta, Boolean(this.stop), this.course.isLocked());
    this.figures.classList.toggle("is-asking", this.isOpen);
    if (this.reached !== stage.isRevealed) {
      this.reached = stage.isRevealed;
      for (const box of [this.body, ...this.figures.querySelectorAll(".pictures, .drawing")]) reachable(box);
    }
    this.#drawLegend(drawn);
    this.#drawAgain();
    const said = this.card.spoken();
    if (said !== this.said) this.course.announce(this.said = said);
  }

  // Answers

  answered() {
    this.isAsked = false;
    this.course.note("");
    this.course.keep();
    this.course.answered(this.stage);
    this.course.redraw();
  }

  /** @param {Mark} mark */
  mark(mark) {
    this.stage.mark = mark;
    if (this.stage.step.ask.kind === "place") this.answered();
    else this.course.redraw();
  }

  /** @param {Slider} slider @param {number} value */
  slid(slider, value) {
    const {stage} = this, {ask} = stage.step;
    if (slider.name.startsWith("knob ")) {
      stage.sliders.set(slider.name, value);
      this.course.redraw();
      return;
    }
    stage.slide(slider.name, value);
    if (ask.kind === "pose" && !stage.isRevealed) {
      stage.answer = {pose: [stage.sliders.get("guess 1") ?? 0, stage.sliders.get("guess 2") ?? 0]};
      stage.mark = /** @type {Mark} */ (stage.answer.pose);
      this.answered();
    }
  }

  released() {
    this.course.keep();
    this.#look();
  }

  /** One step, which counts. @param {number[]} theta */
  #go(theta) {
    const {stage} = this;
    this.#glide(theta, () => {
      stage.move(theta);
      stage.step.sliders?.forEach(({name}, k) => stage.sliders.set(name, theta[k] / DEGREE));
      this.course.keep();
      this.#look();
    });
  }

  /** Whether what has to be reached is reached. */
  #look() {
    const {stage} = this, {ask} = stage.step;
    if (ask.kind !== "do" || stage.isRevealed || this.stop || !isReached(stage)) return;
    stage.answer = {done: true};
    this.course.answered(stage);
    if (this.course.isHeld()) this.course.keep();
    else this.reveal(false);
  }

  /** Both knobs turn the arm, and the prediction is compared with what came of it. */
  turn() {
    const {stage} = this, {mark, chosen} = stage, {ask} = stage.step, side = ask.figure === "R" ? 1 : 0;
    if (!mark || !this.isOpen) return;
    const at = () => /** @type {Mark} */ ([0, 1].map(k => stage.moment.views.own[4 * chosen + 2 * side + k]));
    const from = at(), theta = stage.knobbed, knobs = [stage.sliders.get("knob 1") ?? 0, stage.sliders.get("knob 2")
      ?? 0];
    this.#glide(theta, () => {
      stage.move(theta);
      stage.rounds = [...stage.rounds, {mark, from, to: at(), knobs,
        measure: Number(measure(stage, ask.measure ?? "").value)}];
      stage.mark = null;
      for (const name of ["knob 1", "knob 2"]) stage.sliders.set(name, 0);
      this.course.answered(stage);
      this.course.keep();
      if (arePlayed(stage) && !this.course.isHeld()) this.reveal(false);
      this.course.redraw();
    });
  }

  // Showing the truth

  /** "Show me": at once after an answer, else at the second press. */
  show() {
    const {stage} = this, {ask} = stage.step;
    if (stage.isRevealed || this.stop) return;
    if (isAnswered(stage) && (ask.kind !== "predict" || arePlayed(stage))) return this.reveal(false);
    if (!this.isAsked && ask.kind !== "do" && ask.kind !== "predict") {
      this.isAsked = true;
      this.course.note(touched(FIRST));
      this.course.announce(touched(FIRST));
      return;
    }
    this.reveal(true);
  }

  /** @param {boolean} isUnanswered */
  reveal(isUnanswered) {
    const {stage} = this, {step} = stage;
    if (stage.isRevealed) return;
    if (isUnanswered && step.ask.kind === "do") return this.#solve();
    this.#reveal(isUnanswered);
  }

  /** @param {boolean} isUnanswered */
  #reveal(isUnanswered) {
    const {stage} = this, {step} = stage;
    if (isUnanswered) stage.answer = {...stage.answer, shown: true};
    if (step.ask.kind === "bet") stage.bets = Object.assign([...stage.bets], {[stage.run]: stage.answer.bet ?? null});
    this.course.note("");
    const lasts = step.play ? 1000 * step.play : step.meets ? MEET_MS : 0;
    const from = stage.moment.theta, to = stage.moment.thetaDemo;
    this.#play(lasts, (share, isOver) => {
      stage.reveal = Math.max(1e-6, share);
      const eased = smoothstep(share);
      if (step.meets) stage.observe(isOver ? to : from.map((v, k) => v + eased * (to[k] - v)));
    }, () => {
      stage.graded ??= grade(stage);
      this.course.keep();
    });
    if (!step.meets) stage.graded ??= grade(stage);
    this.course.keep();
    this.body.scrollTop = 0;
  }

  /** The next claim to bet on. */
  #nextRun() {
    const {stage} = this;
    stage.run++;
    stage.answer = {};
    stage.graded = null;
    stage.reveal = 0;
    this.isAsked = false;
    this.course.keep();
    this.body.scrollTop = 0;
    this.course.redraw();
  }

  /** The sliders go to a solution. */
  #solve() {
    if (this.isSolving) return;
    this.isSolving = true;
    const {stage} = this, found = solution(stage), from = new Map(stage.sliders);
    this.#play(SOLVE_MS, share => {
      const eased = smoothstep(share);
      for (const [name, to] of found) {
        const start = from.get(name) ?? to;
        stage.slide(name, start + eased * (to - start));
      }
    }, () => {
      this.isSolving = false;
      if (stage.step.ask.measure === "E" && !stage.isShown) stage.showAt(stage.moment.theta);
      this.#reveal(true);
    });
  }

  /** The arm goes to a posture. @param {number[]} theta @param {() => void} arrived */
  #glide(theta, arrived) {
    const from = this.stage.moment.theta;
    this.#play(MOVE_MS, share => this.stage.observe(between(from, theta, share)), arrived);
  }

  /** @param {number} lasts ms @param {(share: number, isOver: boolean) => void} frame @param {() => void} over */
  #play(lasts, frame, over) {
    this.stop?.();
    let isOver = false;
    const stop = play(lasts, share => {
      frame(share, share === 1);
      if (share < 1) this.course.redraw();
    }, () => {
      isOver = true;
      this.stop = null;
      over();
      this.course.redraw();
    });
    if (!isOver) this.stop = stop;
  }

  // Buttons and keys

  /** @returns {Button} */
  primary() {
    const {stage, course} = this;
    if (stage.isRevealed && stage.step.ask.kind === "bet" && stage.run + 1 < stage.runs) return {words: "Next run",
      key: "→", filled: true, disabled: course.isLocked(), act: () => this.#nextRun()};
    if (stage.isRevealed) return {words: "Next", key: "→", filled: true, disabled: course.isLocked(),
      act: () => { this.stop?.(); course.go(1); }};
    const isPredicted = stage.step.ask.kind === "predict", isOver = !isPredicted || arePlayed(stage);
    if (!isOver && isSet(stage)) return {words: "Turn", key: "↵", filled: true,
      disabled: course.isLocked() || Boolean(this.stop), act: () => this.turn()};
    if (course.isHeld()) return {words: isAnswered(stage) ? "Answered" : "Your answer?", disabled: true, act: () => {}};
    const isReady = isAnswered(stage) && isOver;
    return {words: "Show me", key: isReady ? "↵" : undefined, filled: isReady, disabled: course.isLocked()
      || Boolean(this.stop), act: () => this.show()};
  }

  /** @returns {Button | null} */
  skip() {
    const {stage, course} = this;
    return stage.isRevealed ? null : {words: "Skip step", disabled: course.isLocked(), act: () => course.go(1)};
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (this.course.isLocked()) return false;
    if (this.marks?.key(event)) return true;
    return Boolean(this.card.ask.key?.(event.key));
  }

  remove() {
    this.stop?.();
    this.sizes.disconnect();
    for (const {figure} of this.mounted) figure.remove?.();
  }

  // What stands beside

  /** Another start, and its number. */
  #drawAgain() {
    const {stage, course} = this, isOffered = stage.isRevealed
      && Boolean(stage.step.randomise || stage.step.ask.kind === "predict") && !this.stop;
    this.again.hidden = !isOffered;
    if (!isOffered || this.again.childElementCount) return;
    const box = make("input", {type: "number", min: 1, max: MAX_SEED, value: stage.seed,
      "aria-label": "Number of the start"});
    box.addEventListener("change", () => { if (box.validity.valid && box.value) course.restart(Number(box.value)); });
    this.again.append(button("Again, from a new start", () => course.restart(stage.seed % MAX_SEED + 1)),
      make("p", {class: "hint"}, "This was start ", box, ". Others can play the same."));
  }

  /** @param {Set<string>} drawn layers */
  #drawLegend(drawn) {
    const rows = [...new Set(this.mounted.flatMap(({kind}) => Object.entries(kind.legend ?? {})).filter(([layer]) =>
      drawn.has(layer)).map(([, html]) => html))];
    const links = this.course.links(this.stage).map(({href, words, of}) =>
      `<a class="to-${of}" href="${href}">${words}</a>`).join(" ");
    const html = rows.map(one => `<li>${one}</li>`).join("") + (links && `<li class="elsewhere">${links}</li>`);
    if (this.legend.dataset.html !== html) {
      this.legend.dataset.html = html;
      this.legend.innerHTML = html;
    }
    this.legend.hidden = !html;
  }
}

/** The box of a figure, and its title. @param {FigureUse} use @param {boolean} isAsked */
export function framed({figure}, isAsked) {
  const kind = FIGURES[figure], box = make("div", {class: "drawing"}), [title, ...rest] = (kind?.title ?? "").split(", ");
  const caption = inline(title) + (rest.length ? `<span class="rest">, ${inline(rest.join(", "))}</span>` : "");
  if (!kind) box.textContent = `There is no figure “${figure}” here.`;
  const element = make("figure", {class: `figure figure-${figure.replace(/\W+/g, "-")}${isAsked ? " asked" : ""}`,
    style: `--aspect:${kind?.aspect ?? 1}`}, make("figcaption", {html: caption}), box);
  return {element, box, kind};
}

/** What scrolls can be reached by keys. @param {Element} box */
function reachable(box) {
  if (box.scrollHeight > box.clientHeight + 1 && getComputedStyle(box).overflowY !== "hidden") {
    if (!box.hasAttribute("tabindex")) box.setAttribute("tabindex", "0");
  } else if (!box.matches(".asked *")) box.removeAttribute("tabindex");
}

/** What a figure shows now. @param {FigureUse} use @param {Stage} stage */
export function layersOf({show = [], reveal = [], hide = []}, {isRevealed}) {
  return new Set(isRevealed ? [...show.filter(layer => !hide.includes(layer)), ...reveal] : show);
}
