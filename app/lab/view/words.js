/** What the page says of a moment, in sentences. */
import {energyText, fixed} from "./svg.js";

/** @typedef {import("../engine/session.js").Moment} Moment */

const DEGREE = Math.PI / 180, EXACT_DEG = 0.05;

/** @type {Record<string, {title: string, says: string}>} */
export const SERVO_WORDS = {
  broyden: {title: "Broyden", says: "Learns how its pictures move, then goes where it predicts the smallest E: 5 to 10 steps."},
  "gradient-retuned": {title: "Retuned", says: "Learns only how E falls, with bounded steps and a little shaking: some hundred steps."},
  gradient: {title: "Paper’s", says: "The law as printed in 2001: its steps shrink with E, so it slows to a crawl."},
};

/** @type {Record<string, {title: string, says: string}>} */
export const TRANSFER_WORDS = {
  epipolar: {title: "Epipolar", says: "The paper’s: a point lies where its epipolar lines cross. Assumes cameras without perspective."},
  linear: {title: "Linear", says: "Each own picture is a linear combination of the other two. No lines, so none can be parallel."},
  projective: {title: "Projective", says: "The same with one depth for each point: exact for parallel pinhole cameras."},
};

/**
 * @param {Moment} now
 * @param {boolean} playing
 * @param {number} points of the body
 * @returns {{state: string, text: string}}
 */
export function outcome(now, playing, points) {
  const E = `E is ${energyText(now.E)} px²`, steps = `${now.motion} ${now.motion === 1 ? "step" : "steps"}`;
  if (now.status === "too-few-points") return {state: "stuck", text: "Too few points are visible in all four pictures: it needs five."};
  if (points < 5) return {state: "stuck", text: "With four points, E is 0 in every pose: the pictures cannot disagree."};
  if (now.status === "settled") {
    const smallest = now.E < .005 ? `${E}.` : `${E}, not 0.`;
    return {state: "settled", text: `At a local minimum after ${steps}: ${smallest}${playing ? " Move the demonstrator, and it follows." : ""}`};
  }
  if (now.status === "no-progress" && !playing) return {state: "stuck", text: `No lower E found lately: ${E} after ${steps}.`};
  if (playing) return {state: "moving", text: now.probe ? "A test move: it turns one joint to see how its pictures change." : `Copying. The pictures disagree: ${E}.`};
  return now.motion ? {state: "moving", text: `The pictures disagree: ${E} after ${steps}.`}
    : {state: "ready", text: `Ready. The pictures disagree: ${E}. Press Play, or pose the orange robot.`};
}

/**
 * The truth, which the learner does not know.
 *
 * @param {number[]} theta
 * @param {number[]} thetaDemo
 * @param {string[]} joints
 */
export function truth(theta, thetaDemo, joints) {
  const off = theta.map((v, k) => Math.abs(v - thetaDemo[k]) / DEGREE), worst = off.indexOf(Math.max(...off));
  if (off[worst] < EXACT_DEG) return "Hidden from the learner: it has exactly the demonstrator’s pose.";
  const [is, should] = [theta, thetaDemo].map(angles => `${fixed(angles[worst] / DEGREE)}°`);
  return `Hidden from the learner: ${fixed(off[worst])}° off. Its ${joints[worst].toLowerCase()} is at ${is} but should be at ${should}.`;
}
