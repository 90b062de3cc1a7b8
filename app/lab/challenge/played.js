/** The games that this device remembers: steps of the first game of each pose. */
import {Memory} from "../view/memory.js";
import {wordOf} from "./rules.js";

const MAX_GAMES = 100;

export class Played {
  memory = new Memory(() => localStorage, "viewimit-");
  /** Steps by level and word, 0 where the pose was not found. @type {Record<string, number>} */
  games = Object.fromEntries(Object.entries(this.memory.read("challenge") ?? {}).filter(([, steps]) => Number.isInteger(steps)));

  /** Count a game, if it is the first of its pose.
   * @param {import("./rules.js").Challenge} challenge @param {number} steps 0 if the pose was not found
   * @returns {{isPractice: boolean, best: number}} best: fewest steps on this level, 0 for none */
  add(challenge, steps) {
    const {level} = challenge, game = `${level} ${wordOf(challenge)}`, isPractice = Object.hasOwn(this.games, game);
    if (!isPractice) this.games = Object.fromEntries([...Object.entries(this.games).slice(1 - MAX_GAMES), [game, steps]]);
    this.memory.set("challenge", JSON.stringify(this.games));
    const found = Object.entries(this.games).filter(([name, made]) => made && name.startsWith(`${level} `)).map(([, made]) => made);
    return {isPractice, best: found.length ? Math.min(...found) : 0};
  }
}
