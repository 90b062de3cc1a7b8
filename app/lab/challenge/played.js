/** The games that this device remembers: steps of the first game of each pose. */
import {wordOf} from "./rules.js";

const KEY = "viewimit-challenge", MAX_GAMES = 100;

/** @returns {Record<string, number>} steps by level and word, 0 where the pose was not found */
function kept() {
  try {
    const games = Object.entries(JSON.parse(localStorage.getItem(KEY) ?? "{}"));
    return Object.fromEntries(games.filter(([, steps]) => Number.isInteger(steps)));
  } catch { return {}; } // nothing is kept, or not by this page
}

export class Played {
  games = kept();

  /** Count a game, if it is the first of its pose.
   * @param {import("./rules.js").Challenge} challenge @param {number} steps 0 if the pose was not found
   * @returns {{isPractice: boolean, best: number}} best: fewest steps on this level, 0 for none */
  add(challenge, steps) {
    const {level} = challenge, game = `${level} ${wordOf(challenge)}`, isPractice = Object.hasOwn(this.games, game);
    if (!isPractice) this.games = Object.fromEntries([...Object.entries(this.games).slice(1 - MAX_GAMES), [game, steps]]);
    try { localStorage.setItem(KEY, JSON.stringify(this.games)); } catch { /* it lives as long as the page */ }
    const found = Object.entries(this.games).filter(([name, made]) => made && name.startsWith(`${level} `)).map(([, made]) => made);
    return {isPractice, best: found.length ? Math.min(...found) : 0};
  }
}
