/** The solution for a visitor who needs it: where the sliders reach the goal.
 * @import {Stage} from "./stage.js" */
import {isReached} from "./answers.js";
import {measure} from "./measures.js";

const GRID = 9, ROUNDS = 40, MIN_SHARE = 1e-4; // values of a slider at first; rounds of a search that halves its steps

/** Where the step's sliders bring its measure to the goal, or as near as was found: a grid, then a pattern search
 * (Hooke & Jeeves 1961). The stage is left as it was.
 * @param {Stage} stage @returns {Map<string, number>} */
export function solution(stage) {
  const {sliders = []} = stage.step, {measure: name, below} = stage.step.ask, before = new Map(stage.sliders),
    {changed} = stage;
  const sign = below !== null && below !== undefined ? 1 : -1, posture = stage.moment.theta;
  stage.changed = () => {};
  const span = sliders.map(({low, high, logarithmic}) => logarithmic ? [Math.log(low), Math.log(high)] : [low, high]);
  const values = (/** @type {number[]} */ at) => at.map((share, k) => {
    const value = span[k][0] + Math.min(1, Math.max(0, share)) * (span[k][1] - span[k][0]);
    return sliders[k].logarithmic ? Math.exp(value) : value;
  });
  const cost = (/** @type {number[]} */ at) => {
    values(at).forEach((value, k) => stage.slide(sliders[k].name, value));
    const found = Number(measure(stage, name ?? "").value);
    return Number.isNaN(found) ? Infinity : sign * found;
  };
  let best = sliders.map((slider, k) => {
    const value = before.get(slider.name) ?? slider.start;
    return ((slider.logarithmic ? Math.log(value) : value) - span[k][0]) / (span[k][1] - span[k][0]);
  });
  let least = cost(best);
  const visit = (/** @type {number[]} */ at) => {
    const found = cost(at);
    if (found < least) [least, best] = [found, at];
    return found <= least;
  };
  const ticks = Array.from({length: GRID}, (_, i) => i / (GRID - 1));
  if (sliders.length === 1) ticks.forEach(a => visit([a]));
  else if (sliders.length === 2) ticks.forEach(a => ticks.forEach(b => visit([a, b])));
  for (let round = 0, step = .5 / GRID; round < ROUNDS && step > MIN_SHARE
    && !(cost(best), isReached(stage)); round++) {
    const from = least;
    for (let k = 0; k < best.length; k++) for (const way of [-step, step]) visit(best.map((v, i) => i === k ? v + way
      : v));
    if (least >= from) step /= 2;
  }
  const found = new Map(values(best).map((value, k) => [sliders[k].name, value]));
  stage.observe(posture);
  for (const [slider, value] of before) stage.slide(slider, value);
  stage.changed = changed;
  return found;
}
