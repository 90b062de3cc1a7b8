/** The demonstrator moved to other places in the room: it keeps its pose and faces the same way, and the eyes turn to
 * follow it.
 * @import {Stage} from "./stage.js" @import {Camera} from "../engine/camera.js"
 * @typedef {{x: number, y: number, E: number}} Place how far it was moved, m ahead of the eyes and to their left,
 * and E there */
import {cross, Session, unit, World} from "../engine/engine.js";

/** Where it is moved, m: away from the eyes (x) and sideways (y). */
export const MOVES = /** @type {[number, number][]} */ ([[0, 0.5], [0.5, 0], [1, 1], [-0.3, 0]]);

/** A head of two parallel cameras, turned about its middle to look at a point.
 * @param {[Camera, Camera]} pair @param {ArrayLike<number>} gaze m @returns {[Camera, Camera]} */
export function turnedTo(pair, gaze) {
  const middle = [0, 1, 2].map(i => (pair[0].centre[i] + pair[1].centre[i]) / 2);
  const half = Math.hypot(...pair[1].centre.map((v, i) => v - middle[i]));
  const ahead = unit(middle.map((v, i) => gaze[i] - v)), right = unit(cross(ahead, [0, 0, 1]));
  const down = cross(ahead, right);
  const rotation = [0, 1, 2].flatMap(i => [right[i], down[i], ahead[i]]);
  const made = pair.map((camera, k) =>
    ({...camera, rotation, centre: middle.map((v, i) => v + (k ? half : -half) * right[i])}));
  return [made[0], made[1]];
}

/** E with the demonstrator moved. @param {Stage} stage @param {[number, number]} by m */
export function energyMoved({world, moment, session, state}, [x, y]) {
  const {scene} = world, [l, r, L, R] = scene.cameras, base = scene.bases.demonstrator;
  const gaze = scene.gaze ?? [base[3], base[7], base[11]];
  const moved = base.map((v, k) => v + (k === 3 ? x : k === 7 ? y : 0));
  const eyes = turnedTo([l, r], [gaze[0] + x, gaze[1] + y, gaze[2]]);
  const there = new World({...scene, bases: {...scene.bases, demonstrator: moved}, cameras: [...eyes, L, R]},
    state.points);
  return new Session(there, {...session.settings, demonstrator: moment.thetaDemo, start: moment.theta}).now.E;
}

/** All places where it is moved, with E. @param {Stage} stage @returns {Place[]} */
export const movedPlaces = stage => MOVES.map(([x, y]) => ({x, y, E: energyMoved(stage, [x, y])}));
