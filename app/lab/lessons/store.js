/**
 * Answers that are kept in the browser, lesson by lesson. Where a browser keeps nothing, they live as long as the page.
 * @import {Answer, Mark, Round, Measured} from "./stage.js" @import {Givens} from "./questions.js"
 * @typedef {Object} KeptStep
 * @property {Answer} answer
 * @property {Mark | null} mark
 * @property {number} seed
 * @property {boolean} revealed
 * @property {boolean | null} right
 * @property {{theta: number[], E: number, probe: boolean}[]} motions
 * @property {Round[]} rounds
 * @property {[string, number][]} sliders
 * @property {Record<string, Measured> | null} [graded] the numbers that judged the answer
 * @property {number} [run]
 * @property {(number | null)[]} [bets]
 * @typedef {{steps: Record<string, KeptStep>, before: Givens, after:
 * Givens, person: number}} Kept */
const PREFIX = "viewimit-lesson-", PERSONS = 2 ** 31;

export class Store {
  constructor() {
    this.lessons = /** @type {Record<string, Kept>} */ ({});
    this.keeps = true; // whether the browser keeps what it is given
    this.suspended = /** @type {Record<string, Kept> | null} */ (null); // what the store kept before it was suspended
    try {
      localStorage.setItem(`${PREFIX}test`, "1");
      localStorage.removeItem(`${PREFIX}test`);
    } catch { this.keeps = false; }
  }

  /** @param {string} lesson @returns {Kept} */
  of(lesson) {
    if (!this.lessons[lesson]) {
      let kept = /** @type {Partial<Kept>} */ ({});
      try { kept = JSON.parse(localStorage.getItem(PREFIX + lesson)
        ?? "{}"); } catch { /* nothing is kept, or not by this page */ }
      this.lessons[lesson] = {steps: kept.steps ?? {}, before: kept.before ?? {}, after: kept.after ?? {},
        person: kept.person ?? Math.floor(Math.random() * PERSONS)};
    }
    return this.lessons[lesson];
  }

  /** @param {string} lesson */
  save(lesson) {
    if (!this.keeps || this.suspended) return;
    try { localStorage.setItem(PREFIX + lesson, JSON.stringify(this.of(lesson))); } catch { this.keeps = false; }
  }

  /** Go on with a copy that is not kept. */
  suspend() { this.suspended ??= structuredClone(this.lessons); }

  /** Go on with the suspended answers. */
  putBack() {
    if (this.suspended) this.lessons = this.suspended;
    this.suspended = null;
  }

  /** @param {string} lesson */
  forget(lesson) {
    const {person} = this.of(lesson);
    this.lessons[lesson] = {steps: {}, before: {}, after: {}, person};
    this.save(lesson);
  }
}
