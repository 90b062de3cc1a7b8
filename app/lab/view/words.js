/** What the page says of a moment, in sentences.
 * @import {Moment} from "../engine/session.js" */
import METHODS from "../../../assets/lab/methods.json" with {type: "json"};
import VERDICTS from "../../../assets/verdicts.json" with {type: "json"};
import {DEGREE, MIN_POINTS} from "../engine/engine.js";
import {fixed} from "./svg.js";

const EXACT_DEG = 0.05;

/** @type {Record<string, {title: string, says: string, periodMs: number}>} ms of a step */
export const SERVO_WORDS = METHODS.servos;
/** @type {Record<string, {title: string, says: string}>} */
export const TRANSFER_WORDS = METHODS.transfers;

/** How a status is told, as in every front end. Colour of the mark: none, blue, green, amber, red or grey.
 * @type {Record<string, {label: string, says: string, dot: string}>} */
export const verdicts = VERDICTS;

/** @param {Moment} now @param {boolean} playing @param {number} points of the body
 * @param {number} posedAt the motion at which the demonstrator moved last
 * @returns {{status: string, label: string, text: string, dot: string}} */
export function outcome(now, playing, points, posedAt) {
  const few = points < MIN_POINTS, ended = few ? "too-few-points" : now.status;
  const isUnderWay = ended === "moving" && (playing || now.motion > 0);
  const status = ended in verdicts && ended !== "moving" ? ended : isUnderWay ? "moving" : "ready";
  const {label, says, dot} = told(status, {steps: now.motion - posedAt, E: now.E, seen: now.usable.length});
  const more = few ? "With fewer, E is 0 in every pose."
    : posedAt && (status === "settled" || status === "no-progress") ? "Steps count from the demonstrator’s last pose."
    : status === "ready" ? "Press Play, or pose the demonstrator."
    : status !== "moving" || !playing ? "" : now.probe
      ? "A test move: it turns one joint to see how its pictures change." : "It goes where it expects a smaller E.";
  return {status, label, text: [says, more].filter(Boolean).join(" "), dot};
}

/** The verdict of a status on one run, as `Verdict.sentence` in Python has it.
 * @param {string} status
 * @param {{steps: number, E: number, seen?: number, joints?: string, expectedOffDeg?: number | null}} run joints:
 * names of those that the points do not show; expectedOffDeg: what the learner expects to be off, if it says so
 * @returns {{label: string, says: string, dot: string}} */
export function told(status, {steps, E, seen = 0, joints = "every joint", expectedOffDeg = null}) {
  const {label, says, dot} = verdicts[status];
  const sentence = expectedOffDeg === null ? says.split(" It expects", 1)[0] : says;
  const off = expectedOffDeg === null ? "" : `${fixed(Math.max(expectedOffDeg, .1), expectedOffDeg >= 10 ? 0 : 1)}°`;
  return {label, dot, says: fill(sentence, {steps: stepsText(steps), differ: residualText(E), seen, joints, off})};
}

/** @param {string} text with {places} @param {Record<string, string | number>} parts */
const fill = (text, parts) => text.replace(/\{(\w+)\}/g, (_, name) => String(parts[name] ?? ""));

/** The truth, which the learner does not know.
 * @param {number[]} theta @param {number[]} thetaDemo @param {string[]} joints @param {number} E px² */
export function truth(theta, thetaDemo, joints, E) {
  const off = theta.map((v, k) => Math.abs(v - thetaDemo[k]) / DEGREE);
  if (Math.max(...off) < EXACT_DEG) {
    const rest = E >= .005 ? " What is left of E comes from perspective and noise." : "";
    return `Hidden from the learner: it has exactly the demonstrator’s pose.${rest}`;
  }
  const each = off.map((v, k) => `its ${joints[k].toLowerCase()}${k ? "" : " is"} ${fixed(v)}°`);
  return `Hidden from the learner: ${each.join(" and ")} off.`;
}

/** @param {number} count */
export const stepsText = count => `${count} ${count === 1 ? "step" : "steps"}`;

/** The root of E: how long a typical arrow is. @param {number} E px² */
export const residualText = E => Number.isNaN(E) ? "–" : `${fixed(Math.sqrt(E), E >= 100 ? 0 : 1)} px`;
