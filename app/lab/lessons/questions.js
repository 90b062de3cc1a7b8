/** The eight questions, asked before and after: their answers are shuffled, and each has "sure" or "guess" beside it.
 * @import {Question} from "./stage.js"
 * @typedef {{answer: number, right: boolean, sure: boolean, seconds: number}} Given answer: its index in the file
 * @typedef {Record<string, Given>} Givens by the question's id
 * @typedef {{words: string, go: (() => void) | null, href: string | null}} Link to a step or a lesson */
import {button, inline, make, option} from "./dom.js";
import {shuffledOrder} from "./stage.js";

export const QUESTION_S = 28; // of each question, to estimate what a round takes

/** In which order a person gets the answers of a question.
 * @param {Question} question @param {number} k its number @param {number} person @param {"before" | "after"} phase */
export const orderOf = ({answers}, k, person, phase) =>
  shuffledOrder(answers.length, person * 64 + 2 * k + (phase === "after" ? 1 : 0));

/** @param {Link} to @param {string} look the class of a button */
export const linked = ({words, go, href}, look) => go
  ? button(words, go, look)
  : make("a", {href, class: look === "plain" ? "button" : null}, words);

/** How many are right. @param {Question[]} questions @param {Givens} given */
export const rightOf = (questions, given) => questions.filter(({id}) => given[id]?.right).length;

/** The normalised gain (Hake 1998): the share of the wrong answers before that is right after; null where nothing was
 * wrong.
 * @param {number} before @param {number} after @param {number} count */
export const gain = (before, after, count) => before === count ? null : (after - before) / (count - before);

/** How many were guessed. @param {Question[]} questions @param {Givens} given */
export const guessedOf = (questions, given) => questions.filter(({id}) => given[id] && !given[id].sure).length;

/** "4 → 7 of 8, gain 0.75", in words. @param {Question[]} questions @param {Givens} before @param {Givens} after */
export function outcome(questions, before, after) {
  const count = questions.length, pre = rightOf(questions, before), post = rightOf(questions, after),
    g = gain(pre, post, count);
  const isPaired = questions.every(({id}) => before[id] && after[id]);
  if (!isPaired) return {label: "Right after", large: `${post} of ${count}`,
    words: "You did not answer all questions both before and after, so there is no gain to state."};
  const words = g === null ? "You had all of them right before." : `Gain ${g.toFixed(2).replace("-", "−")}: ${post >= pre
    ? `of the ${count - pre} that you had wrong, ${post - pre} more ${post - pre === 1 ? "is" : "are"} right now.` : "fewer are right now than before."}`;
  return {label: "Right before, right after", large: `${pre} → ${post} of ${count}`, words:
    `${words} Guessed: ${guessedOf(questions, before)} of ${count} → ${guessedOf(questions, after)} of ${count}.`};
}

/** One question as something to press.
 * @param {Question} question @param {number[]} order
 * @param {{answer: number | null, sure: boolean | null}} now what has been pressed @param {() => void} changed */
export function questionOf(question, order, now, changed) {
  const take = (/** @type {number} */ k) => {
    now.answer = order[k];
    changed();
  };
  const options = order.map((original, k) => option(String(k + 1), inline(question.answers[original].text), () => take(k)));
  const sure = /** @type {[string, string, boolean][]} */ ([["S", "I am sure", true], ["G", "I am guessing", false]]).map(
    ([key, words, value]) => ({value, key, button: option(key, words, () => {
      now.sure = value;
      changed();
    })}));
  const element = make("div", {class: "asked-question"}, make("h2", {tabindex: -1, html: inline(question.text)}),
    make("div", {class: "options", role: "group", "aria-label": "Answers"}, ...options),
    make("div", {class: "sure", role: "group", "aria-label": "How sure are you?"}, ...sure.map(({button}) => button)));
  return {
    element,
    update() {
      options.forEach((one, k) => {
        const isChosen = now.answer === order[k];
        one.className = `option${isChosen ? " chosen" : ""}`;
        one.setAttribute("aria-pressed", String(isChosen));
      });
      for (const {button, value} of sure) {
        button.disabled = now.answer === null;
        button.className = `option sureness${now.sure === value ? " chosen" : ""}`;
        button.setAttribute("aria-pressed", String(now.sure === value));
      }
    },
    /** @param {string} key @returns {boolean} */
    key(key) {
      const k = Number(key) - 1, one = sure.find(({key: own}) => own === key.toUpperCase());
      if (k in options) take(k);
      else if (one && now.answer !== null) {
        now.sure = one.value;
        changed();
      } else return false;
      return true;
    },
  };
}

/** The review: the right answer of each question, one sentence why, and the step that shows it.
 * @param {Question[]} questions @param {Givens} before @param {Givens} after @param {(step: string) => Link | null} link */
export function reviewOf(questions, before, after, link) {
  const mark = (/** @type {Given | undefined} */ given) =>
    make("span", {class: given ? given.right ? "yes" : "no" : "none", role: "img", "aria-label": given
    ? `${given.right ? "right" : "wrong"}${given.sure ? ", sure" : ", guessed"}` : "not answered"},
    given ? given.right ? "✓" : "✗" : "–", given ? make("small", {}, given.sure ? "sure" : "guess") : null);
  const rows = questions.map((question, k) => {
    const right = question.answers.find(answer => answer.right) ?? question.answers[0], at = question.step
      ? link(question.step) : null;
    const wrong = after[question.id] && !after[question.id].right ? question.answers[after[question.id].answer] : null;
    return make("li", {class: after[question.id]?.right === false ? "open" : ""},
      make("span", {class: "number"}, String(k + 1)),
      make("div", {class: "words"}, make("p", {html: inline(question.text)}),
        make("p", {class: "right-answer", html: inline(right.text)}),
        make("p", {class: "because", html: inline(right.because)}),
        wrong && make("p", {class: "because wrong-answer",
          html: `<b>Your answer “${inline(wrong.text)}”</b> ${inline(wrong.because)}`})),
      mark(before[question.id]), mark(after[question.id]),
      at ? linked(at, "link") : make("span", {}));
  });
  return make("ol", {class: "review"}, make("li", {class: "heads", "aria-hidden": true}, make("span", {}),
    make("span", {}, "right is"), make("span", {}, "before"), make("span", {}, "after"),
    make("span", {}, "shown in")), ...rows);
}
