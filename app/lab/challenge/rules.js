/** The rules of a challenge, without a document: what is offered, the robot's steps, the link.
 * @import {World} from "../engine/world.js"
 * @typedef {"easy" | "points" | "blindfold"} Level what the player sees
 * @typedef {{demonstrator: number[], start: number[], level: Level, by: string, day: string}} Challenge
 * demonstrator: rad, whole degrees; start: rad, whole degrees; by: who made it, "" if that is not said; day:
 * 2026-11-28 of a daily one, "" otherwise */
import {DEGREE, draws, Session} from "../engine/engine.js";

/** How far off the referee still says "There", and how many steps may be made. @type {Record<Level, {title: string, says: string, withinDeg: number, tries: number}>} */
export const LEVELS = {
  easy: {title: "Easy", withinDeg: 5, tries: 10, says: "You see both arms."},
  points: {title: "Points", withinDeg: 5, tries: 10,
    says: "Of the orange arm you see what the robot sees: ten points."},
  blindfold: {title: "Blindfold", withinDeg: 10, tries: 15, says: "You only learn how far the pictures disagree."},
};
export const POINTS = 10;
export const TRANSFER = "projective"; // with the epipolar one nobody can tell the last degrees
export const SERVO = "broyden";
const MAX_ROBOT = 30; // steps, after which it has failed
const EDGE_DEG = 8, ELBOW_DEG = [20, 160], FAR_DEG = [30, 100], ROBOT_STEPS = [4, 8], MAX_DRAWS = 400;

/** Degrees by which each joint is off: exactly 5 where whole degrees are 5 apart. @param {number[]} theta @param {number[]} goal */
export const jointsOff = (theta, goal) => theta.map((v, k) => Number((Math.abs(v - goal[k]) / DEGREE).toFixed(6)));

/** Degrees of the joint that is farthest off. @param {number[]} theta @param {number[]} goal */
export const degreesOff = (theta, goal) => Math.max(...jointsOff(theta, goal));

/** @param {World} world @param {Challenge} challenge */
export const sessionOf = (world, {demonstrator, start}) =>
  new Session(world, {transfer: TRANSFER, servo: SERVO, demonstrator, start});

/** How many steps the robot makes until the same referee stops it, its test moves counted; null if it never arrives.
 * @param {World} world @param {Challenge} challenge */
export function robotSteps(world, challenge) {
  const session = sessionOf(world, challenge), {withinDeg} = LEVELS[challenge.level];
  for (let steps = 1; steps <= MAX_ROBOT && session.step(); steps++)
    if (degreesOff(session.now.theta, challenge.demonstrator) <= withinDeg) return steps;
  return null;
}

/** Joint limits in whole degrees, as far as a link can say them. @param {World} world */
const limits = ({scene: {lower, upper}}) => lower.map((low, k) =>
  [Math.ceil(Math.max(low / DEGREE, -FARTHEST)), Math.floor(Math.min(upper[k] / DEGREE, FARTHEST))]);

/** Why a pose is no good challenge; "" for a good one. @param {World} world @param {Challenge} challenge */
export function refusal(world, challenge) {
  const {demonstrator, start} = challenge, elbow = Math.abs(demonstrator[1]) / DEGREE;
  const isAtEnd = (/** @type {number[]} */ theta) => limits(world).some(([low, high], k) =>
    Math.min(theta[k] / DEGREE - low, high - theta[k] / DEGREE) < EDGE_DEG);
  if (isAtEnd(demonstrator)) return "A joint is at its end: move it a little.";
  if (elbow < ELBOW_DEG[0]) return "A stretched arm hides its pose: bend the elbow.";
  if (elbow > ELBOW_DEG[1]) return "A folded arm hides its pose: open the elbow.";
  if (isAtEnd(start)) return "The blue arm stands at its end: move it a little.";
  const far = degreesOff(demonstrator, start), robot = far < FAR_DEG[0] ? 0 : robotSteps(world, challenge);
  if (robot !== null && robot < ROBOT_STEPS[0]) return "Too easy: the blue arm already stands nearly so.";
  if (far > FAR_DEG[1]) return "The blue arm stands too far away: move it a little.";
  return robot === null || robot > ROBOT_STEPS[1] ? "Even the robot does not find this pose soon. Try another." : "";
}

/** A challenge that a seed gives; null if this robot offers none.
 * @param {World} world @param {number} seed @param {Level} level
 * @param {number[] | null} [pose] rad, of the demonstrator: its start alone is drawn @returns {Challenge | null} */
export function drawChallenge(world, seed, level, pose = null) {
  const draw = draws(seed), ends = limits(world);
  const any = () => ends.map(([low, high]) => Math.round(low + draw() * (high - low)) * DEGREE);
  for (let n = 0; n < MAX_DRAWS; n++) {
    const challenge = {demonstrator: pose ?? any(), start: any(), level, by: "", day: ""};
    if (!refusal(world, challenge)) return challenge;
  }
  return null;
}

/** The same for all on a date, and another pose on each level, so that none gives the other away. @param {World} world @param {string} day @param {Level} level */
export function daily(world, day, level) {
  const challenge = drawChallenge(world, 10 * Number(day.replaceAll("-", "")) + Object.keys(LEVELS).indexOf(level), level);
  return challenge && {...challenge, day};
}

/** A challenge of a pose that somebody has made: from the start on show, or else from one that makes it a good one.
 * @param {World} world @param {Pick<Challenge, "demonstrator" | "start" | "level" | "by">} made
 * @returns {Challenge | string} why it is none */
export function fromPose(world, {demonstrator, start, level, by}) {
  const whole = (/** @type {number[]} */ theta) => theta.map(v => Math.round(v / DEGREE) * DEGREE);
  const challenge = {demonstrator: whole(demonstrator), start: whole(start), level, by: shortName(by), day: ""};
  const why = refusal(world, challenge);
  if (!why) return challenge;
  const seed = demonstrator.reduce((sum, v) => 511 * sum + Math.round(v / DEGREE), 7);
  const other = drawChallenge(world, seed, level, challenge.demonstrator);
  return other ? {...other, by: challenge.by} : why;
}

// The link. A readable pose would give the answer away, so both poses stand in one short word: four angles of nine
// bits and five bits that tell a mistyped one, in base 36.

const FARTHEST = 255, BITS = 9n, CHECK_BITS = 5n, LETTERS = 8, MAX_NAME = 20;
const DISGUISE = 0x5bd12f3a6n; // so that an angle is no digit of the word

/** @param {number[]} whole */
const checkOf = whole => BigInt(whole.reduce((sum, v, k) => sum + v * (2 * k + 3), 0) & 31);

/** The name of somebody as a link and a sentence may hold it. @param {string} name */
export const shortName = name => name.replace(/[\p{C}\s]+/gu, " ").trim().slice(0, MAX_NAME).trim();

/** The link's word: a date, or the poses. @param {Challenge} challenge */
export function wordOf({demonstrator, start, day}) {
  if (day) return day;
  const whole = [...demonstrator, ...start].map(v => Math.round(v / DEGREE) + FARTHEST + 1);
  const bits = whole.reduce((all, v) => all << BITS | BigInt(v), 0n) << CHECK_BITS | checkOf(whole);
  return (bits ^ DISGUISE).toString(36).padStart(LETTERS, "0");
}

/** @param {Challenge} challenge */
export function toLink(challenge) {
  const {level, by} = challenge;
  return `#challenge=${wordOf(challenge)}${level === "points" ? "" : `&level=${level}`}`
    + (by ? `&by=${encodeURIComponent(by)}` : "");
}

/** Whether an address asks for a challenge. @param {string} hash */
export const asksForChallenge = hash => /^#(.*&)?challenge(=|&|$)/.test(hash);

/** @param {World} world @param {string} hash @returns {Challenge | null} null for a link that holds none */
export function fromLink(world, hash) {
  const asked = new URLSearchParams(hash.replace(/^#/, "")), word = asked.get("challenge") ?? "";
  const by = shortName(asked.get("by") ?? ""), named = asked.get("level") ?? "points";
  if (!Object.hasOwn(LEVELS, named)) return null;
  const level = /** @type {Level} */ (named);
  if (/^\d{4}-\d\d-\d\d$/.test(word)) return daily(world, word, level);
  if (!/^[0-9a-z]{8}$/.test(word)) return null;
  const bits = [...word].reduce((all, digit) => all * 36n + BigInt(parseInt(digit, 36)), 0n) ^ DISGUISE;
  const whole = [3n, 2n, 1n, 0n].map(k => Number(bits >> CHECK_BITS + BITS * k & 511n));
  if (bits >> CHECK_BITS + 4n * BITS || checkOf(whole) !== (bits & 31n)) return null;
  const theta = whole.map(v => (v - FARTHEST - 1) * DEGREE), ends = limits(world);
  const challenge = {demonstrator: theta.slice(0, 2), start: theta.slice(2), level, by, day: ""};
  const isWithin = whole.every((v, k) => v - FARTHEST - 1 >= ends[k & 1][0] && v - FARTHEST - 1 <= ends[k & 1][1]);
  return isWithin && robotSteps(world, challenge) ? challenge : null;
}
