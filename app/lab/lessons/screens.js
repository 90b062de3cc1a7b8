/** The screens of the eight questions, and of a lesson's end.
 * @import {Lesson} from "./stage.js" @import {Given, Link} from "./questions.js" @import {Kept} from "./store.js"
 * @import {Screen, Button} from "./step-screen.js" */
import {inline, make} from "./dom.js";
import {linked, orderOf, outcome, questionOf, reviewOf} from "./questions.js";

/** @implements {Screen} What stands still, holds nothing and takes no key. */
export class StillScreen {
  draw() { /* nothing changes */ }

  /** @param {KeyboardEvent} _event */
  key(_event) { return false; }

  /** @returns {Button} */
  primary() { return {words: "", act: () => {}}; }

  /** @returns {Button | null} */
  skip() { return null; }

  remove() { /* nothing is held */ }
}

/** One of the eight questions. */
export class QuestionScreen extends StillScreen {
  /** @param {HTMLElement} body @param {Lesson} lesson @param {"before" | "after"} phase @param {number} k
   * @param {Kept} kept
   * @param {{keep: (id: string, given: Given) => void, go: (by: number) => void, skipAll:
   * () => void, redraw: () => void}} acts */
  constructor(body, lesson, phase, k, kept, acts) {
    super();
    const questions = lesson.questions ?? [], one = questions[k], was = kept[phase][one.id], began = performance.now();
    this.acts = acts;
    this.now = {answer: was ? was.answer : null, sure: was ? was.sure : /** @type {boolean | null} */ (null)};
    this.question = questionOf(one, orderOf(one, k, kept.person, phase), this.now, () => {
      const {answer, sure} = this.now;
      if (answer !== null && sure !== null) acts.keep(one.id,
        {answer, sure, right: Boolean(one.answers[answer].right),
        seconds: Math.round((performance.now() - began) / 100) / 10});
      acts.redraw();
    });
    const lead = phase === "before"
      ? "Before the lesson. A guess is enough: you get the same questions again at the end."
      : "After the lesson: the same questions again.";
    body.replaceChildren(make("p", {class: "lead"}, lead), this.question.element);
  }

  draw() { this.question.update(); }

  /** @param {KeyboardEvent} event */
  key(event) { return this.question.key(event.key); }

  /** @returns {Button} */
  primary() {
    const isReady = this.now.answer !== null && this.now.sure !== null;
    return {words: "Next", key: isReady ? "↵" : undefined, filled: isReady, disabled: !isReady, act: () =>
      this.acts.go(1)};
  }

  /** @returns {Button} */
  skip() { return {words: "Skip the questions", act: this.acts.skipAll}; }
}

/** What one can say now, and the review of the questions. */
export class EndScreen extends StillScreen {
  /** @param {HTMLElement} body @param {HTMLElement} figures @param {Lesson} lesson @param {Kept} kept
   * @param {(step: string) => Link | null} link
   * @param {Link | null} next the lesson after this one @param {Button} leave */
  constructor(body, figures, lesson, kept, link, next, leave) {
    super();
    const questions = lesson.questions ?? [], wasAsked = Object.keys(kept.after).length > 0;
    this.leave = leave;
    const says = make("ul", {class: "says"}, ...lesson.steps.map(({say, id}) =>
      make("li", {class: kept.steps[id]?.revealed ? "" : "open", html: inline(say.replace(/\{[^}]*\}/g, "…"))})));
    if (questions.length && wasAsked) {
      const {label, large, words} = outcome(questions, kept.before, kept.after),
        missed = questions.filter(({id}) => kept.after[id] && !kept.after[id].right);
      const first = missed.map(({step}) => step ? link(step) : null).find(Boolean);
      body.replaceChildren(make("h2", {tabindex: -1}, "Eight questions, before and after"),
        make("div", {class: "headline"}, make("span", {}, label), make("strong", {}, large),
        make("small", {}, words)));
      if (first) body.append(linked({...first, words: `Go to ${first.words}`}, "plain"));
      figures.replaceChildren(reviewOf(questions, kept.before, kept.after, link), make("h3", {}, "Now you can say"),
        says);
    } else {
      body.replaceChildren(make("h2", {tabindex: -1}, "Done"),
        make("p", {class: "text"}, "You have reached the end of this lesson."));
      figures.replaceChildren(make("h3", {}, "Now you can say"), says);
    }
    if (next) body.append(linked(next, "plain"));
    figures.dataset.main = figures.dataset.side = "0";
  }

  /** @returns {Button} */
  primary() { return this.leave; }
}
