/** Measures of the lesson on the image Jacobian: how well landings were predicted, and how many steps a gain or a
 * turned camera costs.
 * @import {Stage, Measure} from "./stage.js" @import {Run} from "./teach_by_showing.js" */
import {DEGREE, fixed} from "../view/svg.js";
import {measured} from "./measured.js";
import {once} from "../view/once.js";
import {coordinatesOf, stepsTo, teachByShowing} from "./teach_by_showing.js";

export const GAINS = [0.1, 1, 2.2];
export const THERE_PX = 2; // rms: so near counts as arrived
const GAIN_PROBE_DEG = 15, TURNED_PROBE_DEG = 5; // of each joint, from which the first Jacobian is learned
const TURNED_GAIN = 0.3, TURNED_POINT = 9; // the servo of the turned camera sees one point, in L alone
export const GAIN_STEPS = 40;
export const TURNED_STEPS = 40;
const SWINGS = 10; // last steps of a gain that never arrives

/** The same way with three gains: Broyden's update corrects J after each step. @param {Stage} stage @returns {Run[]} */
export const gainRuns = stage => once(stage, "gains", () => GAINS.map(gain => teachByShowing(stage.world, {
  start: stage.state.start, goal: stage.state.demonstrator, gain, update: true, steps: GAIN_STEPS,
  coordinates: coordinatesOf(stage.world.body.length, true), probeRad: GAIN_PROBE_DEG * DEGREE,
})));

/** The point that the servo of the turned camera sees. @param {Stage} stage */
export const turnedPoint = stage => Math.min(TURNED_POINT, stage.world.body.length - 1);

/** With the camera as it was, with a turned one and the old Jacobian, and with one that Broyden's update corrects.
 * @param {Stage} stage @param {number} [rollDeg] @returns {{still: Run, old: Run, broyden: Run}} */
export function turnedRuns(stage, rollDeg = stage.sliders.get("roll") ?? 90) {
  const point = turnedPoint(stage), common = {
    start: stage.state.start, goal: stage.state.demonstrator, gain: TURNED_GAIN, steps: TURNED_STEPS,
    coordinates: [4 * point, 4 * point + 1], probeRad: TURNED_PROBE_DEG * DEGREE,
  };
  return once(stage, `turned ${rollDeg}`, () => ({
    still: teachByShowing(stage.world, {...common, update: false}),
    old: teachByShowing(stage.world, {...common, update: false, rollRad: rollDeg * DEGREE}),
    broyden: teachByShowing(stage.world, {...common, update: true, rollRad: rollDeg * DEGREE}),
  }));
}

/** The roll at which the step begins, degrees. @param {Stage} stage */
const firstRoll = ({step}) => step.sliders?.find(({name}) => name === "roll")?.start ?? 90;

/** @param {Run} run */
const steps = run => measured(stepsTo(run, THERE_PX), "", 0, "never");

/** How far off each prediction was, px. @param {Stage} stage */
const errors = ({rounds}) => rounds.map(({mark, to}) => Math.hypot(mark[0] - to[0], mark[1] - to[1]));

/** @type {Record<string, Measure>} */
export const JACOBIAN_MEASURES = {
  "rms px to the goal": ({world, moment}) => {
    const own = moment.views.own, goal = world.look("learner", moment.thetaDemo).images, count = own.length / 4;
    let sum = 0;
    for (let i = 0; i < count; i++) sum += (own[4 * i] - goal[4 * i]) ** 2 + (own[4 * i + 1] - goal[4 * i + 1]) ** 2;
    return measured(Math.sqrt(sum / count), " px");
  },
  "your first errors": stage => {
    const first = errors(stage).slice(0, 2), text = first.map(value => fixed(value, 0)).join(" and ");
    return {value: first[0] ?? NaN, unit: " px", text: first.length ? `${text} px` : "–"};
  },
  "your last error": stage => measured(errors(stage).pop() ?? NaN, " px", 1),
  "your last share": stage => {
    const last = stage.rounds[stage.rounds.length - 1], off = errors(stage).pop() ?? NaN;
    return measured(last ? 100 * off / Math.hypot(last.to[0] - last.from[0], last.to[1] - last.from[1]) : NaN, " %", 0);
  },
  "steps at 0.1": stage => steps(gainRuns(stage)[0]),
  "steps at 1": stage => steps(gainRuns(stage)[1]),
  "px at 2.2": stage => {
    const last = gainRuns(stage)[2].errors.slice(-SWINGS), [least, most] = [Math.min(...last), Math.max(...last)];
    return {value: most, unit: " px", text: `${fixed(least, 0)} to ${fixed(most, 0)} px`};
  },
  "steps, not turned": stage => steps(turnedRuns(stage, firstRoll(stage)).still),
  "steps, old": stage => steps(turnedRuns(stage, firstRoll(stage)).old),
  "steps, Broyden": stage => steps(turnedRuns(stage, firstRoll(stage)).broyden),
};
