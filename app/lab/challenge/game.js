/** One game of a challenge, without a document: where the arm is, what was made, and what is said of it.
 * @import {World} from "../engine/world.js" @import {Challenge} from "./rules.js" */
import {fixed} from "../view/svg.js";
import {residualText, stepsText} from "../view/words.js";
import {degreesOff, jointsOff, LEVELS, robotSteps, sessionOf} from "./rules.js";

/** One square for each step: green there, yellow within 10°, orange within 30°, red beyond. @param {number[]} off degrees @param {number} withinDeg */
export const squares = (off, withinDeg) =>
  off.map(one => one <= withinDeg ? "🟩" : one <= 10 ? "🟨" : one <= 30 ? "🟧" : "🟥").join("");

/** A joint without its symbol. @param {string} name */
export const plainName = name => name.replace(/ \S+$/, "");

export class Game {
  /** @param {World} world @param {Challenge} challenge */
  constructor(world, challenge) {
    this.world = world;
    this.challenge = challenge;
    this.level = LEVELS[challenge.level];
    this.session = sessionOf(world, challenge);
    this.robot = robotSteps(world, challenge); // steps of the robot
    this.moment = this.session.now; // what is seen now
    this.path = [this.#stand()]; // where the arm has stood, the start first
    this.isOver = false;
  }

  #stand() {
    const {theta, E} = this.moment;
    return {theta, E, off: degreesOff(theta, this.challenge.demonstrator)};
  }

  /** How many steps were made. */
  get made() { return this.path.length - 1; }

  get isThere() { return this.made > 0 && this.path[this.made].off <= this.level.withinDeg; }

  /** The arm on its way, which is no step. @param {number[]} theta */
  pass(theta) { this.moment = this.session.observe(theta); }

  /** The arm has arrived, and the referee looks. @param {number[]} theta */
  step(theta) {
    this.pass(theta);
    this.path.push(this.#stand());
    this.isOver = this.isThere || this.made >= this.level.tries;
  }

  get disagreement() { return `The pictures disagree by ${residualText(this.moment.E)}`; }

  /** What the last step has brought, as px of the step before. */
  get change() {
    const [before, now] = this.path.slice(-2).map(({E}) => Math.sqrt(E)), share = Math.round(100 * (1 - now / before));
    return share ? `${Math.abs(share)} % ${share > 0 ? "less" : "more"} than before` : "as before";
  }

  get verdict() {
    const {made, robot, isThere, level} = this, steps = stepsText(made), too = robot === null ? "" : ` The robot needed ${robot}.`;
    if (isThere && robot !== null && made <= robot) return `${made < robot ? "Faster than" : "As fast as"} the robot: ${steps}.`;
    return `${isThere ? `There, after ${steps}.` : made >= level.tries ? `Not found in ${steps}.`
      : made ? `You gave up after ${steps}.` : "You gave up before the first step."}${too}`;
  }

  /** How far off the arm ended. */
  get fact() {
    const {theta, off} = this.path[this.made];
    const each = jointsOff(theta, this.challenge.demonstrator).map((v, k) =>
      `${plainName(this.world.scene.names[k]).toLowerCase()} ${fixed(v)}°`);
    return `You stopped ${fixed(off)}° off: ${each.join(", ")}. The dashed outline is the pose.`;
  }

  /** To be sent: words first, squares on a line of their own, and where it can be played. @param {string} address "" for none @param {boolean} isPractice */
  line(address, isPractice) {
    const {challenge: {day}, level: {title, withinDeg}, made, robot} = this, off = this.path.slice(1).map(one => one.off);
    const found = this.isThere ? `${stepsText(made)}, ${off[made - 1].toFixed(1)}° off` : `not found in ${stepsText(made)}`;
    const what = `viewimit ${day || "challenge"} (${title}${isPractice ? ", practice" : ""})`;
    return [`${what}: ${found}. Robot: ${robot ?? "–"}.`, squares(off, withinDeg), address]
      .filter(Boolean).join("\n");
  }
}
