/** Measures of the tour: the crossing, the arrows, E in other places, and how much a small E leaves open.
 * @import {Stage, Measure} from "./stage.js" */
import {energy, placed, short, measured} from "./measured.js";
import {movedPlaces, energyMoved} from "./places.js";
import {DEGREE, fixed} from "../view/svg.js";

/** Points that the images name: one of the hand, whose arrow is short though it has far to go, and one of the base. */
export const HAND_POINT = 9;
export const BASE_POINT = 3;
const STEP_DEG = 1; // of the map on which poses below the goal are counted

/** A point in L, px. @param {Float64Array} images @param {number} i */
const inL = (images, i) => [images[4 * i], images[4 * i + 1]];

/** Points of the learner in the demonstrator's posture, (4 N) px. @param {Stage} stage */
const ghostImages = ({world, moment}) => world.look("learner", moment.thetaDemo).images;

/** @param {number[]} p @param {number[]} q */
const distance = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1]);

/** The residual of a point in L, px. @param {Stage} stage @param {number} i */
const arrowOf = (stage, i) => distance(inL(stage.recovered(), i), inL(stage.moment.views.own, i));

/** How far a point in L is from where it goes, px. @param {Stage} stage @param {number} i */
const wayOf = (stage, i) => distance(inL(stage.moment.views.own, i), inL(ghostImages(stage), i));

/** Of all arrows, followed backwards from dot to diamond, with the ways to the ghost, over L and R.
 * @param {Stage} stage */
function cosine(stage) {
  const {own} = stage.moment.views, found = stage.recovered(), goal = ghostImages(stage);
  let both = 0, arrows = 0, ways = 0;
  for (const i of stage.moment.usable) for (let k = 4 * i; k < 4 * i + 4; k++) {
    both += (found[k] - own[k]) * (goal[k] - own[k]);
    arrows += (found[k] - own[k]) ** 2;
    ways += (goal[k] - own[k]) ** 2;
  }
  return both / Math.sqrt(arrows * ways);
}

/** How far off a posture can be while E stays below the goal, degrees of the joint that is farthest off.
 * @param {Stage} stage */
function widest(stage) {
  const {goal, moment} = stage, landscape = stage.landscape(STEP_DEG);
  let most = 0;
  for (let g = 0; g < landscape.count; g++) if (goal !== null && landscape.E[g] < goal)
    most = Math.max(most, ...landscape.posture(g).map((v, k) => Math.abs(v - moment.thetaDemo[k])));
  return most / DEGREE;
}

/** px², of the arrow that is longest in L or R. @param {Stage} stage */
function longestShare(stage) {
  const {own} = stage.moment.views, found = stage.recovered(), squares = stage.moment.usable.flatMap(i =>
    [0, 2].map(k => (own[4 * i + k] - found[4 * i + k]) ** 2 + (own[4 * i + k + 1] - found[4 * i + k + 1]) ** 2));
  return Math.max(...squares) / squares.reduce((sum, v) => sum + v, 0);
}

/** @type {Record<string, Measure>} */
export const TOUR_MEASURES = {
  "recovered in L": stage => placed(inL(stage.recovered(), stage.chosen)),
  "ghost point in L": stage => placed(inL(ghostImages(stage), stage.chosen)),
  "crossing to own point": stage =>
    measured(arrowOf(stage, stage.chosen), " px", arrowOf(stage, stage.chosen) < 10 ? 1 : 0),
  "crossing to ghost": stage =>
    measured(distance(inL(stage.recovered(), stage.chosen), inL(ghostImages(stage), stage.chosen)), " px", 0),
  "arrow of 3": stage => measured(arrowOf(stage, BASE_POINT), " px", 0),
  "arrow of 9": stage => measured(arrowOf(stage, HAND_POINT), " px", 0),
  "way of 9": stage => measured(wayOf(stage, HAND_POINT), " px", 0),
  "cosine": stage => measured(cosine(stage), "", 2),
  "E sideways": stage => energy(energyMoved(stage, [0, 0.5])),
  "E back": stage => energy(energyMoved(stage, [0.5, 0])),
  "E nearer": stage => energy(energyMoved(stage, [-0.3, 0])),
  "times by place": stage => {
    const E = [stage.moment.E, ...movedPlaces(stage).map(place => place.E)];
    return measured(Math.max(...E) / Math.min(...E), "", 1);
  },
  "times by shape": stage => measured(stage.moment.E / stage.ghost().E, "", 0),
  "your end": ({moment, scene, steps, isShown}) => {
    if (!steps || isShown) return measured(NaN);
    const degrees = moment.theta.map(v => v / DEGREE), names = scene.names.map(name => name.split(" ")[0].toLowerCase());
    return {value: degrees, unit: "°", text: degrees.map((v, k) => `${names[k]} ${fixed(v, 0)}°`).join(" and ")};
  },
  "your guess": ({answer, step}) => {
    const unit = step.ask.unit ?? "", {number = NaN} = answer;
    return {value: number, unit, text: `${short(number).replace(/\.0+$/, "")}${unit}`};
  },
  "share of the longest": stage => measured(100 * longestShare(stage), " %", 0),
  "widest below the goal": stage => measured(widest(stage), "°", 0),
};
