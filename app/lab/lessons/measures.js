/** Measures: numbers, places and postures that a step asks for, tells and has in braces. The facts of the library come
 * first, then those computed here.
 * @import {Stage, Measure, Measured} from "./stage.js" */
import {DEGREE, farthest} from "../engine/engine.js";
import {distance, energy, placed, measured} from "./measured.js";
import {LIMITS_MEASURES} from "./measures_limits.js";
import {JACOBIAN_MEASURES} from "./measures_jacobian.js";
import {RAY_MEASURES} from "./measures_ray.js";
import {TOUR_MEASURES} from "./measures_tour.js";

/** Motions after which E was below the goal first. @param {ArrayLike<number>} E @param {number | null} goal */
export function reached(E, goal) {
  const at = goal === null ? -1 : Array.from(E).findIndex(value => value < goal);
  return measured(at < 0 ? NaN : at, "", 0, "never");
}

/** @param {Stage} stage @param {string} servo */
function raced(stage, servo) {
  const race = stage.race(servo);
  return race ? reached(race.E, stage.goal) : measured(NaN);
}

/** From the mark to the truth: px, or degrees on maps and between postures. @param {Stage} stage @returns {Measured} */
function markError(stage) {
  const {ask} = stage.step;
  if (ask.kind === "pose") {
    const truth = /** @type {number[]} */ (measure(stage, ask.truth ?? "").value);
    return measured(stage.answer.pose ? Math.max(...stage.answer.pose.map((v, k) => Math.abs(v - truth[k]))) : NaN, "°", 0);
  }
  const off = distanceOf(stage, ask.truth ?? "");
  return stage.unit === "rad" ? measured(off, "°", 0) : measured(off, " px", off < 10 ? 1 : 0);
}

/** From the mark to a place or a line: px, or degrees on maps. @param {Stage} stage @param {string} name the measure */
export function distanceOf(stage, name) {
  const truth = stage.mark && name ? judged(stage, name).value : null;
  return stage.mark && truth ? distance(stage.mark, truth) / (stage.unit === "rad" ? DEGREE : 1) : NaN;
}

/** Whether a claim that is bet on is true. @param {Stage} stage */
const outcome = stage => Number(measure(stage, stage.step.ask.truth ?? "").value);

/** Where the mark or another place is on the map of E.
 * @param {Stage} stage @param {ArrayLike<number> | null} theta rad */
function energyAt(stage, theta) { return theta ? stage.session.observe(Array.from(theta)).E : NaN; }

/** @type {Record<string, Measure>} */
export const MEASURES = {
  ...RAY_MEASURES,
  ...TOUR_MEASURES,
  ...JACOBIAN_MEASURES,
  "distance in px": markError,
  "distance in degrees": markError,
  "your bet": stage => measured(stage.answer.bet ?? NaN, " %", 0),
  "outcome": stage => ({value: outcome(stage), unit: "", text: outcome(stage) ? "true" : "false"}),
  "penalty": stage => measured(((stage.answer.bet ?? NaN) / 100 - outcome(stage)) ** 2, "", 2),
  "E": stage => energy(stage.moment.E),
  "E alike": stage => energy(stage.ghost().E),
  "smallest E": stage => energy(stage.landscape().minimum?.E ?? NaN),
  "place of the smallest E": stage => placed(stage.landscape().minimum?.theta ?? [NaN, NaN]),
  "E at your mark": stage => energy(energyAt(stage, stage.mark)),
  "smallest E is off": stage => measured(farthest(stage.landscape().minimum?.theta ?? [NaN, NaN],
    stage.moment.thetaDemo), "°", 1),
  "error of the arm": ({motions, moment}) =>
    measured(farthest(motions[motions.length - 1].theta, moment.thetaDemo), "°", 1),
  "your motions to the goal": ({motions, steps, isShown, goal}) => steps && !isShown
    ? reached(motions.map(({E}) => E), goal) : measured(NaN),
  "motions of the likelihood servo": stage => raced(stage, "likelihood"),
  "motions of Broyden": stage => raced(stage, "broyden"),
  "motions of the gradient law": stage => raced(stage, "gradient-retuned"),
  "the demonstrator's posture": stage => placed(stage.moment.thetaDemo.map(v => v / DEGREE)),
  "your first joint is off": stage => measured(Math.abs(stage.guessed[0] - stage.moment.thetaDemo[0]) / DEGREE, "°", 0),
  "your second joint is off": stage => measured(Math.abs(stage.guessed[1] - stage.moment.thetaDemo[1]) / DEGREE, "°", 0),
  "E of your posture": stage => energy(energyAt(stage, stage.guessed)),
  ...LIMITS_MEASURES,
};

/** @param {Stage} stage @param {string} name @returns {Measured} with NaN for what nothing computes */
export function measure(stage, name) {
  const fact = stage.facts[name];
  if (fact) return fact;
  return MEASURES[name]?.(stage) ?? measured(NaN);
}

/** A measure as it was when the truth was shown: later turns of sliders change no judgement.
 * @param {Stage} stage @param {string} name */
export const judged = (stage, name) => stage.graded?.[name] ?? measure(stage, name);

/** All measures that judge the answer or are named beside it, as they are now. @param {Stage} stage */
export function grade(stage) {
  const {ask, headline: number, after = "", say} = stage.step,
    {truth, right, line, measure: goal, elsewhere = []} = ask;
  const inWords = [...JSON.stringify([ask, number, after, say]).matchAll(/\{([^{}":,]*)\}/g)].map(([, name]) => name);
  const names = [truth, right, line, goal, number?.measure, ...elsewhere.map(one => one.truth), "distance in px", ...inWords];
  return Object.fromEntries([...new Set(names)].filter(name => typeof name === "string" && name).map(name => {
    const found = measure(stage, String(name));
    return [name, {...found, value: ArrayBuffer.isView(found.value) ? Array.from(/** @type {any} */ (found.value))
      : found.value}];
  }));
}

/** Words with their {measures}; no line ends between a number and its unit.
 * @param {string} words @param {Stage} stage */
export const fill = (words, stage) => words.replace(/\{([^}]*)\}/g, (_, name) =>
  judged(stage, name).text.replace(/^([−\d.,]+) (?=\S+$)/, "$1\u00a0"));
