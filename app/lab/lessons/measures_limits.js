/** Measures of the lessons on limits and claims that the browser computes.
 * @import {Stage, Measure, Measured} from "./stage.js" @import {Crossing} from "./figures/crossing.js" */
import {energyAt, farthest, projectPoint} from "../engine/engine.js";
import {angleOf, crossingOf, ellipseOf, shiftOf} from "./figures/crossing.js";
import {conditionOf, largestOf} from "./figures/matches.js";
import {runOf} from "./figures/sign.js";
import {Altered} from "./maps.js";
import {energy, measured} from "./measured.js";

const FEWEST = 4; // matches
const NEAR_ZERO = 1, NEAR_DEG = 5; // px², of an E that is explained; degrees
const STEP_M = 1e-4; // for the slope of a projection

/** E of all matches, which are thousands. @param {number} E @returns {Measured} */
const rounded = E => ({value: E, unit: " px²", text: `${Math.round(E)} px²`});

/** Of the two lines. @param {(crossing: Crossing) => number} of @param {string} unit @returns {Measure} */
const ofCrossing = (of, unit) => stage => {
  const found = crossingOf(stage);
  return measured(found ? of(found) : NaN, unit, 1);
};

/** What the same eyes would see if each showed an arm as if all of it were as far away as the middle of its points: the
 * projection to first order.
 * @param {Stage} stage */
function withoutDepth({world, session, moment}) {
  const affine = new Altered(world, {alter: ({seen}, who, theta) => {
    const all = world.arms[who].points(theta, world.body), images = new Float64Array(4 * world.body.length);
    const points = world.body.map((_, i) => [...all.subarray(3 * i, 3 * i + 3)]);
    const middle = [0, 1, 2].map(k => points.reduce((sum, p) => sum + p[k], 0) / points.length);
    world.pairs[who].forEach((camera, side) => {
      const at = projectPoint(camera, middle), slope = [0, 1, 2].map(k => {
        const beside = (/** @type {number} */ by) => projectPoint(camera, middle.map((v, i) => i === k ? v + by : v));
        const [up, down] = [beside(STEP_M), beside(-STEP_M)];
        return [0, 1].map(c => (up[c] - down[c]) / (2 * STEP_M));
      });
      points.forEach((p, i) => [0, 1].forEach(c =>
        images[4 * i + 2 * side + c] = at[c] + slope.reduce((sum, v, k) => sum + v[c] * (p[k] - middle[k]), 0)));
    });
    return {images, seen};
  }});
  return energyAt(affine, session.settings.transfer, affine.look("demonstrator", moment.thetaDemo), [...moment.theta]);
}

/** Of the answers: near 0, above it at the demonstrator's posture, above it elsewhere. @param {Stage} stage */
function swappedAnswer(stage) {
  const found = stage.landscape().minimum;
  if (!found) return NaN;
  return found.E < NEAR_ZERO ? 1 : farthest(found.theta, stage.moment.thetaDemo) < NEAR_DEG ? 2 : 3;
}

/** @type {Record<string, Measure>} */
export const LIMITS_MEASURES = {
  "how E is with swapped points": stage => measured(swappedAnswer(stage), "", 0),
  "E without depth": stage => energy(withoutDepth(stage)),
  "crossing angle": ofCrossing(angleOf, "°"),
  "crossing moves": ofCrossing(shiftOf, " px"),
  "uncertain by": stage => measured(ellipseOf(stage)?.halfAxes[0] ?? NaN, " px", 0),
  "cond A": stage => measured(stage.moment.fitted?.condition ?? NaN, "", 0),
  "baseline": ({world: {pairs: {learner: [left, right]}}}) =>
    measured(100 * Math.hypot(...left.centre.map((v, k) => v - right.centre[k])), " cm", 0),
  "largest E of all matches": stage => rounded(largestOf(stage, 0)),
  "largest E of four matches": stage => rounded(largestOf(stage, FEWEST)),
  "cond A of all matches": stage => measured(conditionOf(stage, false), "", 0),
  "cond A in a plane": stage => measured(conditionOf(stage, true), "", 0),
  "within 1°": stage => measured(Number(runOf(stage).holds), "", 0),
  "off shoulder": stage => measured(runOf(stage).offDeg[0], "°", 1),
  "off elbow": stage => measured(runOf(stage).offDeg[1], "°", 1),
  "certificate": stage => {
    const {certificate} = runOf(stage);
    return measured(certificate === null ? NaN : 100 * certificate, " %", 0, "no probability, as it made no claim");
  },
};
