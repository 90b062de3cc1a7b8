/** The levels, side by side. */
import {make} from "../lessons/dom.js";
import {LEVELS} from "./rules.js";

/** @import {Level} from "./rules.js" */

/** @param {(level: Level) => void} choose */
export function levelButtons(choose) {
  const levels = /** @type {Level[]} */ (Object.keys(LEVELS));
  const buttons = levels.map(level => make("button", {type: "button", onclick: () => choose(level)}, LEVELS[level].title));
  return {
    element: make("div", {class: "levels", role: "group", "aria-label": "Level"}, ...buttons),
    /** @param {Level} chosen @param {boolean} isFixed whether no other can be chosen */
    show: (chosen, isFixed) => buttons.forEach((button, k) => {
      button.setAttribute("aria-pressed", String(levels[k] === chosen));
      button.disabled = isFixed && levels[k] !== chosen;
    }),
  };
}
