/**
 * What a servo is given, and what it answers. It sees image points and its own displacements: never a posture, a body or
 * a camera.
 * @typedef {"moving" | "settled" | "no-progress"} ServoStatus settled: the next motion would be too small to be
 * worth it; no-progress: no way to a smaller E was found
 * @typedef {Object} Observation
 * @property {Float64Array} own (4 N) px, the learner's points in [L, R]; they mean nothing where they are not seen
 * @property {Uint8Array} seen (2 N), 1 for a point seen in L, in R
 * @property {number} E px²
 * @property {number[]} displacement rad, since the start
 * @property {number[]} lower rad, what the joint limits allow
 * @property {number[]} upper
 * @property {number} motion how many were made
 * @typedef {(images: Float64Array[]) => {residuals: Float64Array[], count: number}} Conflict what the residuals of
 * own images would be that the servo predicts, NaN for points of which it knows nothing; count: of the points known
 * in all of them. Asking needs no motion
 * @typedef {{status: ServoStatus, probe: boolean}} ServoState probe: the motion is made to learn from */
/** @template {ServoState} S
 * @typedef {Object} Servo
 * @property {(seen: Observation) => S} start the state before the first motion
 * @property {(state: S, seen: Observation, conflict: Conflict) => [S, number[]]} step the next state, and the motion
 *   to make, rad: all 0 to rest
 * @property {(state: S, seen: Observation) => S} retarget where the demonstrator has moved, and E with it */
import {broyden} from "./broyden.js";
import {paperGradient, retunedGradient} from "./gradient.js";

/** By the names that the library's settings have for them. @type {Record<string, Servo<any>>} */
export const SERVOS = {gradient: paperGradient, "gradient-retuned": retunedGradient, broyden};
