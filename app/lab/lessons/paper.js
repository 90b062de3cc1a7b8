/** A lesson on paper, as the browser prints it: each step with its pictures, its question and room for the answer; the
 * solutions come on pages of their own.
 * @import {Lesson, Page, FigureUse} from "./stage.js" */
import {reasonOf, rightChoice} from "./answers.js";
import {inline, make} from "./dom.js";
import {ending, table as tableOf} from "./figures/cards.js";
import {FIGURES} from "./figures/registry.js";
import {fill, grade, measure} from "./measures.js";
import {short} from "./measured.js";
import {solution} from "./solution.js";
import {Stage} from "./stage.js";
import {framed, layersOf} from "./step-screen.js";
import {energyText} from "../view/svg.js";

const ON_SCREEN = ["progress", "standings", "predictions", "dot to goal", "E of both", "claim", "run images", "E history",
  "bets", "review of runs", "verdict", "E axis", "biases"]; // empty, or of one run, before the answer
const MARKS = '<svg viewBox="0 0 26 14" aria-hidden="true">';
const KEY = `<span>${MARKS}<g class="vi-demo"><path class="vi-hull" d="M2 1h22v12H2z"/></g></svg> the demonstrator (orange)</span>
<span>${MARKS}<path class="vi-hull" d="M2 1h22v12H2z"/></svg> the learner (blue)</span>`;

/** Lays lessons out in a box of the page; figures are drawn once they are there, as they need a size. */
class Paper {
  /** @type {(() => void)[]} figures that wait to be drawn */
  #figures = [];

  /** @param {Page} page @param {HTMLElement} box */
  constructor(page, box) {
    this.page = page;
    this.box = box;
  }

  /** @param {Lesson} lesson */
  add(lesson) {
    const stages = stagesOf(this.page, lesson);
    this.#put(this.#sheet(lesson, stages));
    this.#put(this.#key(lesson, stages));
  }

  /** @param {HTMLElement} article */
  #put(article) {
    this.box.append(article);
    for (const draw of this.#figures.splice(0)) draw();
  }

  /** What is answered on. @param {Lesson} lesson @param {Stage[]} stages */
  #sheet(lesson, stages) {
    const box = make("article", {class: "paper-lesson"}, make("header", {}, make("h1", {}, lesson.title),
      make("p", {}, "Name or number: ______________________")), make("p", {class: "paper-key", html: KEY}));
    stages.forEach((stage, k) => box.append(this.#step(stage, k + 1)));
    return box;
  }

  /** The solutions. @param {Lesson} lesson @param {Stage[]} stages */
  #key(lesson, stages) {
    const solved = stages.map((stage, k) => {
      const {step} = stage, words = answerTo(stage);
      stage.answer = {shown: true};
      stage.reveal = 1;
      stage.graded = grade(stage);
      const after = step.after && step.ask.kind !== "bet" && !/\{your /.test(step.after) ? make("p", {html: inline(fill(step.after, stage))}) : null;
      const asked = (step.main ?? []).filter(({figure}) => step.ask.kind === "place" && figure === step.ask.figure);
      return make("section", {}, make("h3", {}, `${k + 1}  ${step.title}`), ...asked.map(use => this.#figure(use, stage)),
        ...words.map(html => make("p", {html})), after, make("p", {class: "paper-say", html: inline(fill(step.say, stage))}));
    });
    return make("article", {class: "paper-lesson paper-solutions"}, make("h2", {}, `Solutions: ${lesson.title}`), ...solved);
  }

  /** @param {Stage} stage @param {number} number */
  #step(stage, number) {
    const {step} = stage, {main = [], side = [], ask} = step;
    const pictures = [...main.map(use => ({use, kind: "large"})), ...side.map(use => ({use, kind: "small"}))]
      .filter(({use}) => FIGURES[use.figure] && !ON_SCREEN.includes(use.figure));
    const words = inline(fill(step.text.replace(/[^.]*\{your [^.]*\.\s*/g, ""), stage));
    const start = stage.sample || ask.kind === "predict" ? make("p", {class: "hint"}, "These pictures are those of start 1 on the screen.") : null;
    return make("section", {class: `paper-step${pictures.length ? "" : " paper-wide"}`},
      make("h3", {}, `${number}  ${step.title}`),
      make("div", {class: "paper-pictures"}, ...pictures.map(({use, kind}) => this.#figure(use, stage, kind))),
      make("div", {class: "paper-words"}, make("p", {html: words}), start,
        make("p", {class: "question", html: inline(onPaper(fill(ask.question, stage)))}), ...roomFor(stage)));
  }

  /** @param {FigureUse} use @param {Stage} stage @param {string} [size] its class */
  #figure(use, stage, size = "large") {
    const {element, box, kind} = framed(use, !stage.isRevealed && use.figure === stage.step.ask.figure);
    element.classList.add(size);
    this.#figures.push(() => kind.create(box, stage).draw(stage, layersOf(use, stage)));
    return element;
  }
}

/** The steps as if nobody had answered them, from start 1. @param {Page} page @param {Lesson} lesson */
function stagesOf(page, {steps}) {
  const made = /** @type {Map<string, Stage>} */ (new Map());
  for (const step of steps) {
    const stage = new Stage(page, step, {seed: 1, previous: made.get(step.carry ?? "") ?? null});
    stage.unit = FIGURES[step.ask.figure ?? ""]?.unit ?? "px";
    made.set(step.id, stage);
  }
  return [...made.values()];
}

/** A question as it is answered with a pencil. @param {string} words */
const onPaper = words => words.replace(/\bClick (in|on)\b/g, "Mark with a cross $1").replace(/\bClick where\b/g, "Mark where");

/** Boxes to tick, lines and tables to fill in. @param {Stage} stage @returns {Node[]} */
function roomFor(stage) {
  const {ask, sliders = []} = stage.step, line = "____________";
  const numbers = (/** @type {string} */ name, /** @type {string[]} */ rows) => [table([name, ...counted(ask.times)],
    rows.map(row => [row, ...counted(ask.times).map(() => "")]))];
  if (ask.kind === "choice") return [...(ask.answers ?? []).map(({text}, k) => make("p", {class: "paper-box",
    html: `<i></i><span>${letter(k)})  ${inline(fill(text, stage))}</span>`})), make("p", {}, `Because ${line.repeat(3)}`)];
  if (ask.kind === "number") return [make("p", {}, `My guess: ${line} ${ask.unit?.trim() ?? ""} (from ${ask.low} to ${ask.high})`)];
  if (ask.kind === "pose") return sliders.map(({label, low, high}) => make("p", {}, `${label}: ${line}° (from ${low} to ${high})`));
  if (ask.kind === "do") return [make("p", {}, `On the screen I came to ${ask.measure === "E" ? "E =" : ""} ${line} ${
    ask.counted ? `in ${line} steps` : ""}`)];
  if (ask.kind === "predict") return numbers("turn", ["off by, px"]);
  if (ask.kind === "bet") return [betsOn(stage)];
  return [];
}

/** The runs that are bet on. @param {Stage} stage */
function betsOn({records, world}) {
  const names = world.scene.names.map(name => name.split(" ")[0].toLowerCase());
  return table(["run", "how it ended", "E, px²", "steps", "points seen", "noise", "my bet, %"],
    records.runs.map((/** @type {any} */ run, /** @type {number} */ k) => [String(k + 1), ending(run.claim, run, names).label,
      energyText(run.E[run.E.length - 1]), String(run.E.length - 1), run.points, run.noise, ""]));
}

/** The right answer, as HTML. @param {Stage} stage @returns {string[]} */
function answerTo(stage) {
  const {ask} = stage.step, {text} = measure(stage, ask.truth ?? "");
  if (ask.kind === "choice") {
    const right = rightChoice(stage), answer = ask.answers?.[right];
    return answer ? [`<b>${letter(right)})</b> ${inline(fill(answer.because, stage))}`] : [];
  }
  if (ask.kind === "number") return [`<b>${text}</b>. ${inline(fill(reasonOf(ask), stage))}`];
  if (ask.kind === "pose") return [/** @type {number[]} */ (measure(stage, ask.truth ?? "").value).map((v, k) =>
    `${stage.step.sliders?.[k].label}: <b>${short(v)}°</b>`).join(", ")];
  if (ask.kind === "do") return [`One way: ${[...solution(stage)].map(([name, value]) =>
    `${stage.step.sliders?.find(one => one.name === name)?.label} <b>${short(value)}</b>`).join(", ")}`];
  if (ask.kind === "bet") return [stage.records.runs.map((/** @type {any} */ {holds, because}, /** @type {number} */ k) =>
    `${k + 1} <b>${holds ? "true" : "false"}</b>: ${inline(because)}`).join("<br>")];
  return [inline(fill(reasonOf(ask), stage))].filter(Boolean);
}

/** @param {number} k */
const letter = k => "abcdef"[k];

/** @param {number | null} [count] */
const counted = count => Array.from({length: count ?? 1}, (_, k) => String(k + 1));

/** @param {string[]} heads @param {string[][]} rows */
const table = (heads, rows) => make("div", {html: tableOf(heads, rows)});

/** Before the browser prints, the paper is laid out in light colours; afterwards it goes.
 * @param {Page} page @param {() => Lesson[]} lessons to print now */
export function printable(page, lessons) {
  const root = document.documentElement;
  let shown = /** @type {HTMLElement | null} */ (null);
  let scheme = root.dataset.scheme;
  addEventListener("beforeprint", () => {
    scheme = root.dataset.scheme;
    root.dataset.scheme = "light";
    root.style.fontSize = "10pt"; // as in paper.css, so that figures have their size now
    shown = document.body.appendChild(make("section", {class: "paper"}));
    const paper = new Paper(page, shown);
    lessons().forEach(lesson => paper.add(lesson));
  });
  addEventListener("afterprint", () => {
    shown?.remove();
    root.dataset.scheme = scheme;
    root.style.fontSize = "";
  });
}
