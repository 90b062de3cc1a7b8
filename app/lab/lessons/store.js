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
import {Memory} from "../view/memory.js";

const PERSONS = 2 ** 31;

export class Store {
  constructor() {
    this.lessons = /** @type {Record<string, Kept>} */ ({});
    this.memory = new Memory(() => localStorage, "viewimit-lesson-");
    this.suspended = /** @type {Record<string, Kept> | null} */ (null); // what the store kept before it was suspended
  }

  /** Whether the browser keeps what it is given. */
  get keeps() { return Boolean(this.memory.storage); }

  /** @param {string} lesson @returns {Kept} */
  of(lesson) {
    if (!this.lessons[lesson]) {
      const kept = /** @type {Partial<Kept>} */ (this.memory.read(lesson) ?? {});
      this.lessons[lesson] = {steps: kept.steps ?? {}, before: kept.before ?? {}, after: kept.after ?? {},
        person: kept.person ?? Math.floor(Math.random() * PERSONS)};
    }
    return this.lessons[lesson];
  }

  /** @param {string} lesson */
  save(lesson) {
    if (!this.suspended) this.memory.set(lesson, JSON.stringify(this.of(lesson)));
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
