/** Where lessons begin: a picture of each, in the order to take them.
 * @import {Lesson} from "./stage.js" @import {Button} from "./step-screen.js"
 * @typedef {{name: string, title: string, about: string, afterwards?: string, minutes: number}} Other served beside
 * this page */
import {button, inline, make} from "./dom.js";
import {QUESTION_S} from "./questions.js";
import {StillScreen} from "./screens.js";

/** @type {Record<string, [number, string]>} the order of the shipped lessons; one's own come first */
const PLACES = {ray: [1, "Begin here"], tour: [2, "Then"], limits: [3, "Then"], jacobian: [4, "For the curious"],
  motion: [5, "For the curious"], sign: [6, "For the curious"]};
const ARM = "M28 64l6-26 22-20 14 16";
/** @type {Record<string, string>} SVG of 120 x 72 */
const PICTURES = {
  ray: `<path class="draw-ray" d="M12 56L108 16"/><circle class="draw-own-dot" cx="44" cy="42.700" r="4"/>
<circle class="draw-hole" cx="74" cy="30.200" r="4"/><path class="draw-up" d="M6 50l10 4-4 10z"/>`,
  tour: `<path class="vi-bone" style="stroke-width:5" d="${ARM}"/><g class="vi-demo"><path class="vi-bone" style="stroke-width:5"
d="M78 64l6-26 22-20 10 16"/></g><path class="vi-e" d="M56 18l-10-8M70 34l-12 6"/>`,
  limits: `<g class="vi-contour"><ellipse cx="60" cy="36" rx="50" ry="24" transform="rotate(-14 60 36)"/><ellipse cx="58"
cy="37" rx="32" ry="14" transform="rotate(-14 58 37)"/></g><path class="vi-cross" d="M46 34v12m-6-6h12"/>
<path class="vi-amber" d="M74 24l6 6-6 6-6-6z"/>`,
  jacobian: `<path class="draw-curve draw-of-learner" d="M12 14q14 44 92 48"/><path class="draw-curve draw-of-plain"
d="M12 14q60 12 92 26"/><path class="draw-level draw-of-goal" d="M8 64h104"/>`,
  motion: `<circle class="draw-curve draw-of-demonstrator" cx="78" cy="30" r="20"/><ellipse class="draw-curve
draw-of-learner" cx="46" cy="40" rx="24" ry="14"/><circle class="draw-own-dot" cx="70" cy="40" r="4"/>`,
  sign: `<path class="vi-plane" d="M24 6h72v60H24z"/><path class="vi-rule" d="M34 20h52M34 30h52M34 40h30"/>
<path class="draw-up" d="M36 56q8-12 12 0t12-2t14-4"/>`,
};

export class Cover extends StillScreen {
  /** @param {HTMLElement} body @param {Lesson[]} lessons @param {Lesson} lesson on which one was
   * @param {(lesson: Lesson) => {words: string, done: number, isAsked: boolean}} stateOf
   * @param {{start: (lesson: Lesson) => void, steps: (lesson: Lesson) => void, step: (lesson: Lesson, id: string) =>
   * void, end: (lesson: Lesson) => void, forget: (lesson: Lesson) => void, catalogue: Other[], beside: (name:
   * string) => string}} acts */
  constructor(body, lessons, lesson, stateOf, acts) {
    super();
    this.start = () => acts.start(lesson);
    this.words = stateOf(lesson).words;
    const rank = (/** @type {{name: string}} */ {name}) => PLACES[name]?.[0] ?? 0;
    const all = [...lessons.map(one => ({name: one.name, minutes: minutesOf(one), more: actsOn(one, stateOf(one), acts), one})),
      ...acts.catalogue.map(one => ({...one, one, more: [make("p", {class: "starts"},
        make("a", {class: "button", href: acts.beside(one.name)}, "Open"))]}))].sort((one, other) => rank(one) - rank(other));
    const minutes = all.reduce((sum, one) => sum + one.minutes, 0);
    body.replaceChildren(make("h2", {tabindex: -1}, all.length < 2 ? "One lesson" : `${all.length} lessons, ${minutes} minutes in all`),
      make("div", {class: "lesson-cards"}, ...all.map(each => pictured({...each.one, asked: each.minutes}, each.more,
        each.one === lesson, all.length > 1))));
  }

  /** @returns {Button} */
  primary() { return {words: this.words, key: "↵", filled: true, act: this.start}; }
}

/** With both rounds of its questions. @param {Lesson} lesson */
const minutesOf = ({minutes, questions}) => minutes + Math.round(2 * QUESTION_S * (questions?.length ?? 0) / 60);

/** @param {Lesson} lesson @param {{words: string, done: number, isAsked: boolean}} state @param {any} acts */
function actsOn(lesson, {words, done, isAsked}, acts) {
  const {questions, steps} = lesson, count = questions?.length ?? 0;
  return [
    make("p", {class: "starts"}, make("button", {type: "button", class: "filled", onclick: () => acts.start(lesson)}, words),
      count && !done ? button("Without the questions before it", () => acts.steps(lesson)) : null,
      isAsked ? button("See the end", () => acts.end(lesson)) : null,
      done ? button("Start again", () => acts.forget(lesson)) : null),
    make("details", {class: "contents"},
      make("summary", {}, `${steps.length} ${steps.length === 1 ? "step" : "steps"}${count ? `, ${count} questions before and after` : ""}${done ? `, ${done} done` : ""}`),
      make("ol", {}, ...steps.map(({id, title}) => make("li", {}, button(title, () => acts.step(lesson, id), "link"))))),
  ];
}

/** @param {Other & {asked: number}} lesson asked: minutes with its questions @param {Node[]} more @param {boolean} isThis @param {boolean} hasOthers */
const pictured = ({name, title, about, afterwards, minutes, asked}, more, isThis, hasOthers) =>
  make("article", {class: `lesson-card${isThis ? " this" : ""}`}, PICTURES[name] ? make("div", {class: "lesson-picture",
    html: `<svg class="vi" viewBox="0 0 120 72" aria-hidden="true">${PICTURES[name]}</svg>`}) : null,
  make("small", {class: "hint"}, `${hasOthers && PLACES[name] ? `${PLACES[name][1]}: ` : ""}${minutes} minutes${
    asked > minutes ? `, with questions ${asked}` : ""}`),
  make("h3", {html: inline(title)}), make("p", {html: inline(about)}),
  afterwards ? make("p", {class: "afterwards", html: `<small>Afterwards</small> ${inline(afterwards)}`}) : null,
  ...more);
