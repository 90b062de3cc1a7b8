/**
 * The screens that are no step: where a lesson begins, one of the eight questions, and its end.
 *
 * @typedef {import("./stage.js").Lesson} Lesson
 * @typedef {import("./store.js").Kept} Kept
 * @typedef {import("./step-screen.js").Screen} Screen
 * @typedef {import("./step-screen.js").Button} Button
 */
import {inline, make} from "./dom.js";
import {linked, orderOf, outcome, questionOf, QUESTION_S, reviewOf} from "./questions.js";

/** @implements {Screen} Where lessons begin. */
export class HomeScreen {
  /**
   * @param {HTMLElement} body
   * @param {Lesson[]} lessons
   * @param {Lesson} lesson
   * @param {(lesson: Lesson) => {words: string, done: number, isAsked: boolean}} stateOf
   * @param {{start: (lesson: Lesson) => void, steps: (lesson: Lesson) => void, step: (lesson: Lesson, id: string) =>
   *   void, end: (lesson: Lesson) => void, forget: (lesson: Lesson) => void,
   *   catalogue: {name: string, title: string, about: string, minutes: number}[], beside: (name: string) => string}} acts
   */
  constructor(body, lessons, lesson, stateOf, acts) {
    this.start = () => acts.start(lesson);
    this.words = stateOf(lesson).words;
    const cards = lessons.map(one => {
      const {words, done, isAsked} = stateOf(one), count = one.steps.length, questions = one.questions?.length ?? 0,
        hasQuestions = questions > 0, round = Math.max(1, Math.round(QUESTION_S * questions / 60));
      const times = `${one.minutes} minutes${hasQuestions ? `, and ${round} for each round of ${questions} questions` : ""}`;
      return make("article", {class: `lesson-card${one === lesson ? " this" : ""}`},
        make("h2", {tabindex: -1, html: inline(one.title)}), make("p", {html: inline(one.about)}),
        make("p", {class: "hint"},
          `${count} ${count === 1 ? "step" : "steps"}, ${times}${done ? `. ${done} done.` : "."}`),
        make("p", {class: "starts"}, make("button", {type: "button", class: "filled", onclick: () => acts.start(one)},
          words),
          hasQuestions && !done ? make("button", {type: "button", class: "plain", onclick: () => acts.steps(one)},
            "Without the questions before it") : null,
          isAsked ? make("button", {type: "button", class: "plain", onclick: () => acts.end(one)}, "See the end")
            : null,
          done ? make("button", {type: "button", class: "plain", onclick: () => acts.forget(one)}, "Start again")
            : null),
        make("ol", {class: "contents"}, ...one.steps.map(step =>
          make("li", {}, make("button", {type: "button", class: "link", onclick: () => acts.step(one, step.id)},
          step.title)))));
    });
    const others = acts.catalogue.map(({name, title, about, minutes}) =>
      make("a", {class: "other-lesson", href: acts.beside(name)}, make("b", {}, title), make("span", {html: inline(about)}),
      make("small", {}, `${minutes} minutes`)));
    body.replaceChildren(...cards, others.length ? make("h3", {}, "Other lessons") : "",
      make("div", {class: "others"}, ...others));
  }

  draw() { /* it stands still */ }

  key() {
    return false;
  }

  /** @returns {Button} */
  primary() {
    return {words: this.words, key: "↵", filled: true, act: this.start};
  }

  skip() {
    return null;
  }

  remove() { /* it holds nothing */ }
}

/** @implements {Screen} One of the eight. */
export class QuestionScreen {
  /**
   * @param {HTMLElement} body
   * @param {Lesson} lesson
   * @param {"before" | "after"} phase
   * @param {number} k
   * @param {Kept} kept
   * @param {{keep: (id: string, given: import("./questions.js").Given) => void, go: (by: number) => void,
   *   skipAll: () => void, redraw: () => void}} acts
   */
  constructor(body, lesson, phase, k, kept, acts) {
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

  draw() {
    this.question.update();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    return this.question.key(event.key);
  }

  /** @returns {Button} */
  primary() {
    const isReady = this.now.answer !== null && this.now.sure !== null;
    return {words: "Next", key: isReady ? "↵" : undefined, filled: isReady, disabled: !isReady, act: () =>
      this.acts.go(1)};
  }

  /** @returns {Button} */
  skip() {
    return {words: "Skip the questions", act: this.acts.skipAll};
  }

  remove() { /* it holds nothing */ }
}

/** @implements {Screen} What one can say now, and the review of the questions. */
export class EndScreen {
  /**
   * @param {HTMLElement} body
   * @param {HTMLElement} figures
   * @param {Lesson} lesson
   * @param {Kept} kept
   * @param {(step: string) => import("./questions.js").Link} link
   * @param {import("./questions.js").Link | null} next the lesson after this one
   * @param {() => void} leave
   */
  constructor(body, figures, lesson, kept, link, next, leave) {
    const questions = lesson.questions ?? [], wasAsked = Object.keys(kept.after).length > 0;
    this.leave = leave;
    const says = make("ul", {class: "says"}, ...lesson.steps.map(({say, id}) =>
      make("li", {class: kept.steps[id]?.revealed ? "" : "open", html: inline(say.replace(/\{[^}]*\}/g, "…"))})));
    if (questions.length && wasAsked) {
      const {large, words} = outcome(questions, kept.before, kept.after),
        missed = questions.filter(({id}) => kept.after[id] && !kept.after[id].right);
      const first = missed.map(({step}) => step ? link(step) : null).find(one => one?.go || one?.href);
      body.replaceChildren(make("h2", {tabindex: -1}, "Eight questions, before and after"),
        make("div", {class: "headline"}, make("span", {}, "Right before, right after"), make("strong", {}, large),
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

  draw() { /* it stands still */ }

  key() {
    return false;
  }

  /** @returns {Button} */
  primary() {
    return {words: "All lessons", key: "↵", filled: true, act: this.leave};
  }

  skip() {
    return null;
  }

  remove() { /* it holds nothing */ }
}
