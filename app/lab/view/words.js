/** What the page says of a moment, in sentences. */
import {fixed} from "./svg.js";

/** @typedef {import("../engine/session.js").Moment} Moment */

const DEGREE = Math.PI / 180, EXACT_DEG = 0.05;
const AGREE_PX = 3, AGREE_PER_NOISE = 2.5; // typical residuals that count as agreement, and more for each px of noise

/** @type {Record<string, {title: string, says: string}>} */
export const SERVO_WORDS = {
  broyden: {
    title: "Broyden",
    says: "Learns how each joint moves its points, then goes where it expects the smallest E: 5 to 10 steps.",
  },
  "gradient-retuned": {
    title: "Retuned",
    says: "The paper’s law with larger steps. At first it turns too far, and E rises again: some hundred steps.",
  },
  gradient: {
    title: "Paper’s",
    says: "As printed in 2001. It may turn too far at first. Its steps shrink with E, so it crawls.",
  },
};

/** @type {Record<string, {title: string, says: string}>} */
export const TRANSFER_WORDS = {
  epipolar: {
    title: "Epipolar",
    says: "The paper’s: each point lies where its lines cross. It neglects that near things look bigger.",
  },
  linear: {
    title: "Linear",
    says: "Without lines: each place in L or R is a weighted sum of the places in l and r.",
  },
  projective: {
    title: "Projective",
    says: "It also knows that near things look bigger. Exact if both cameras look the same way.",
  },
};

/**
 * @param {Moment} now
 * @param {boolean} playing
 * @param {number} points of the body
 * @param {number} noisePx
 * @param {number} posedAt the motion at which the demonstrator moved last
 * @returns {{state: string, text: string}}
 */
export function outcome(now, playing, points, noisePx, posedAt) {
  const residual = residualText(now.E), steps = stepsText(now.motion);
  const when = posedAt ? `${stepsText(now.motion - posedAt)} after the demonstrator moved` : `after ${steps}`;
  const said = (/** @type {string} */ state, /** @type {string} */ text) => ({state, text});
  if (now.status === "too-few-points")
    return said("stuck", "Too few points are visible in all four pictures: it needs five.");
  if (points < 5) return said("stuck", "With four points, E is 0 in every pose: the pictures cannot disagree.");
  const agrees = Math.sqrt(now.E) < AGREE_PX + AGREE_PER_NOISE * noisePx;
  if (now.status === "settled" || now.status === "no-progress") {
    const rests = now.status === "settled", still = `but the pictures still disagree by ${residual}`;
    const next = playing ? " Move the demonstrator, and it follows." : "";
    if (agrees) return said("settled",
      `${rests ? "Converged" : "E no longer falls"} ${when}: the pictures agree to ${residual}.${next}`);
    return said("stuck", rests
      ? `Stopped ${when} without success. By what it has learned, no small turn would lower E, ${still}.`
      : `E no longer falls ${when}, ${still}.`);
  }
  if (playing && now.probe) return said("moving", "A test move: it turns one joint to see how its pictures change.");
  if (playing) return said("moving", "Copying: it goes where it expects a smaller E.");
  if (now.motion) return said("moving", `After ${steps}, the pictures disagree by ${residual}.`);
  if (agrees) return said("ready", `Ready. The pictures already agree to ${residual}.`);
  return said("ready", `Ready. The pictures disagree by ${residual}. Press Play, or pose the demonstrator.`);
}

/**
 * The truth, which the learner does not know.
 *
 * @param {number[]} theta
 * @param {number[]} thetaDemo
 * @param {string[]} joints
 * @param {number} E px²
 */
export function truth(theta, thetaDemo, joints, E) {
  const off = theta.map((v, k) => Math.abs(v - thetaDemo[k]) / DEGREE);
  if (Math.max(...off) < EXACT_DEG) {
    const rest = E >= .005 ? " What is left of E comes from perspective and noise." : "";
    return `Hidden from the learner: it has exactly the demonstrator’s pose.${rest}`;
  }
  const [first, ...others] = off.map((v, k) => `its ${joints[k].toLowerCase()} is ${fixed(v)}°`);
  return `Hidden from the learner: ${[`${first} off`, ...others].join(", ")}.`;
}

/** @param {number} count */
export const stepsText = count => `${count} ${count === 1 ? "step" : "steps"}`;

/** The root of E: how long a typical arrow is. @param {number} E px² */
export const residualText = E => Number.isNaN(E) ? "–" : `${fixed(Math.sqrt(E), E >= 100 ? 0 : 1)} px`;
