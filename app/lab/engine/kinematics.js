/** An arm with revolute joints: where its links, its body points and its hand are, and which posture brings one
 * somewhere.
 *
 * A rigid transform is 3 x 4, row by row: `T_a_b` takes points of frame b to frame a. Postures are in radians, lengths
 * in metres. The learner itself knows nothing of this file: it sees image points only.
 * @typedef {{T: number[], axis: number[], joint: number, multiplier: number, offset: number}} Joint one joint of the
 * chain: `T` is T_parent_joint at angle 0, `axis` a unit vector. Its angle is `multiplier` times that of the moving
 * joint number `joint`, plus `offset`: a joint that mimics another follows it
 * @typedef {{on: number, T: number[]}} Link a link, fixed to frame `on` of the chain: 0 is the base, k follows joint
 * k @typedef {{on: number, at: number[]}} BodyPoint a point, in m, fixed to frame `on` of the chain */
import {clamp, dot, solve} from "./algebra.js";

/** @param {ArrayLike<number>} A @param {ArrayLike<number>} B @returns {Float64Array} the transform A B */
export function compose(A, B) {
  const C = new Float64Array(12);
  for (let i = 0; i < 12; i += 4) for (let j = 0; j < 4; j++)
    C[i + j] = A[i] * B[j] + A[i + 1] * B[4 + j] + A[i + 2] * B[8 + j] + (j === 3 ? A[i + 3] : 0);
  return C;
}

/** @param {ArrayLike<number>} T @param {ArrayLike<number>} p @returns {[number, number, number]} the point T p */
export function transform(T, p) {
  return [
    T[0] * p[0] + T[1] * p[1] + T[2] * p[2] + T[3],
    T[4] * p[0] + T[5] * p[1] + T[6] * p[2] + T[7],
    T[8] * p[0] + T[9] * p[1] + T[10] * p[2] + T[11],
  ];
}

/** Rodrigues' formula. @param {number[]} axis unit vector @param {number} angle rad */
export function rotationAbout([x, y, z], angle) {
  const c = Math.cos(angle), s = Math.sin(angle), t = 1 - c;
  return Float64Array.of(
    1 - t * (y * y + z * z), t * x * y - s * z, t * x * z + s * y, 0,
    t * x * y + s * z, 1 - t * (x * x + z * z), t * y * z - s * x, 0,
    t * x * z - s * y, t * y * z + s * x, 1 - t * (x * x + y * y), 0,
  );
}

export class Arm {
  /** @param {Joint[]} joints @param {Link[]} links @param {number[]} T_world_base */
  constructor(joints, links, T_world_base) {
    this.joints = joints;
    this.links = links;
    this.T_world_base = Float64Array.from(T_world_base);
  }

  /** Forward kinematics: T_world_frame of the base and of what each joint moves. @param {ArrayLike<number>} theta */
  frames(theta) {
    /** @type {Float64Array[]} */
    const found = [this.T_world_base];
    for (const {T, axis, joint, multiplier, offset} of this.joints) {
      const T_world_joint = compose(found[found.length - 1], T);
      found.push(compose(T_world_joint, rotationAbout(axis, multiplier * theta[joint] + offset)));
    }
    return found;
  }

  /** T_world_link of every link, base to hand. @param {ArrayLike<number>} theta */
  linkFrames(theta) {
    const frames = this.frames(theta);
    return this.links.map(({on, T}) => compose(frames[on], T));
  }

  /** @param {ArrayLike<number>} theta @param {BodyPoint[]} body @returns {Float64Array} (3 N) m in the world */
  points(theta, body) {
    const frames = this.frames(theta), found = new Float64Array(3 * body.length);
    body.forEach(({on, at}, i) => found.set(transform(frames[on], at), 3 * i));
    return found;
  }
}

const ROUNDS = 12, DIFFERENCE_RAD = 1e-4, MAX_STEP_RAD = 0.4;

/** Inverse kinematics: the posture within the limits that brings something nearest to a target, by damped least
 * squares. A joint that is pushed against its limit is left out, or the others would overshoot.
 * @param {(theta: number[]) => number[]} place coordinates of that something, m or px
 * @param {number[]} target the coordinates it should have @param {number[]} theta where the search begins
 * @param {number[]} lower @param {number[]} upper @returns {number[]} */
export function reachFor(place, target, theta, lower, upper) {
  for (let round = 0; round < ROUNDS; round++) {
    const here = place(theta), e = target.map((v, i) => v - here[i]);
    const J = theta.map((angle, k) => {
      const step = angle + DIFFERENCE_RAD > upper[k] ? -DIFFERENCE_RAD : DIFFERENCE_RAD;
      return place(theta.map((v, i) => i === k ? v + step : v)).map((v, i) => (v - here[i]) / step);
    });
    const damping = 1e-4 + 0.02 * J.reduce((sum, column) => sum + dot(column, column), 0);
    const free = theta.map(() => true);
    let step = theta.map(() => 0);
    for (let blocked = true; blocked && free.some(Boolean);) {
      const A = J.map((a, i) => J.map((b, j) => free[i] && free[j] ? dot(a, b) + (i === j ? damping : 0) : +(i === j)));
      step = solve(A, J.map((column, k) => free[k] ? dot(column, e) : 0));
      blocked = false;
      theta.forEach((v, k) => {
        const pushes = v <= lower[k] && step[k] < 0 || v >= upper[k] && step[k] > 0;
        if (free[k] && pushes) { free[k] = false; blocked = true; }
      });
    }
    const next = theta.map((v, k) => clamp(v + (free[k] ? clamp(step[k], -MAX_STEP_RAD, MAX_STEP_RAD) : 0), lower[k], upper[k]));
    const moved = Math.max(...next.map((v, k) => Math.abs(v - theta[k])));
    theta = next;
    if (moved < 1e-5) break;
  }
  return theta;
}
