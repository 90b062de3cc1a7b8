/** The games that this device remembers. Where a browser keeps nothing, they live as long as the page. */
import {wordOf} from "./rules.js";

const KEY = "viewimit-challenge", MAX_GAMES = 100;

/** @typedef {[steps: number, degrees: number]} Result of a first game, with no steps if the pose was not found */

export class Played {
  constructor() {
    /** @type {Record<string, Result>} by level and word */
    this.games = {};
    try {
      const kept = JSON.parse(localStorage.getItem(KEY) ?? "{}");
      if (Object.values(kept).every(one => Array.isArray(one) && one.length === 2 && one.every(Number.isFinite))) this.games = kept;
    } catch { /* nothing is kept, or not by this page */ }
  }

  /**
   * The first game of a pose counts.
   *
   * @param {import("./rules.js").Challenge} challenge
   * @param {number} steps 0 if the pose was not found
   * @param {number} off degrees
   * @returns {{first: number | null, best: number}} first: steps of an earlier game of this pose, null for none;
   *   best: fewest steps on this level, 0 for none
   */
  add(challenge, steps, off) {
    const {level} = challenge, game = `${level} ${wordOf(challenge)}`;
    const first = Object.hasOwn(this.games, game) ? this.games[game][0] : null;
    if (first === null) {
      this.games = Object.fromEntries([...Object.entries(this.games).slice(1 - MAX_GAMES), [game, [steps, Math.round(10 * off) / 10]]]);
      try { localStorage.setItem(KEY, JSON.stringify(this.games)); } catch { /* it lives as long as the page */ }
    }
    const found = Object.entries(this.games).filter(([name, [made]]) => name.startsWith(`${level} `) && made).map(([, [made]]) => made);
    return {first, best: found.length ? Math.min(...found) : 0};
  }
}
