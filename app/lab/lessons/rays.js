/** Two cameras and one arm: rays, epipoles, a dolly with its zoom, and the geometry that two pencils of lines make by
 * hand.
 * @import {Camera} from "../engine/camera.js" @import {Stage} from "./stage.js" @import {World} from "../engine/world.js"
 * @typedef {[number, number, number]} Vector
 * @typedef {{a: number, b: number, c: number}} Line a x + b y + c = 0 px, with (a, b) of length 1 */
import {dot} from "../engine/algebra.js";
import {projectPoint} from "../engine/camera.js";
import {compose, transform} from "../engine/kinematics.js";
import {smoothstep} from "../view/svg.js";

/** T⁻¹ of a rigid transform. @param {ArrayLike<number>} T */
function inverse(T) {
  const R = [T[0], T[4], T[8], T[1], T[5], T[9], T[2], T[6], T[10]];
  const at = (/** @type {number} */ k) => -(R[k] * T[3] + R[k + 1] * T[7] + R[k + 2] * T[11]);
  return Float64Array.of(R[0], R[1], R[2], at(0), R[3], R[4], R[5], at(3), R[6], R[7], R[8], at(6));
}

/** A camera moved by a rigid transform. @param {Camera} camera @param {ArrayLike<number>} T @returns {Camera} */
export function moved(camera, T) {
  const R = camera.rotation, pose = [0, 1, 2].flatMap(i => [R[3 * i], R[3 * i + 1], R[3 * i + 2], camera.centre[i]]);
  const moved = compose(T, pose);
  return {...camera, rotation: [0, 1, 2].flatMap(i => [...moved.subarray(4 * i, 4 * i + 3)]),
    centre: [moved[3], moved[7], moved[11]]};
}

/** The two cameras of the first lesson, at one arm: l, and L moved to the demonstrator. As both arms are built alike,
 * the second sees the demonstrator as L sees the learner in the same posture.
 * @param {Pick<World, "arms" | "scene">} world @returns {[Camera, Camera]} */
export function twoCameras({arms: {demonstrator, learner}, scene: {cameras}}) {
  return [cameras[0], moved(cameras[2], compose(demonstrator.T_world_base, inverse(learner.T_world_base)))];
}

/** A camera moved away from a target and zoomed in, its picture shifted so that the target stays where it is in it: the
 * target keeps its size, and its perspective fades. Cameras that move by the same factor keep the direction between
 * them.
 * @param {Camera} camera @param {ArrayLike<number>} target m @param {number} factor of the distance
 * @returns {Camera} */
export function dollied(camera, target, factor) {
  const {focal, principal} = camera, [x, y] = projectPoint(camera, target);
  return {
    ...camera, centre: camera.centre.map((v, i) => target[i] + factor * (v - target[i])),
      focal: focal.map(v => factor * v),
    principal: [x + factor * (principal[0] - x), y + factor * (principal[1] - y)],
  };
}

/** The image of one camera in another's picture. @param {Camera} into @param {Camera} of */
export const epipole = (into, of) => projectPoint(into, of.centre);

/** A place on a camera's ray of a point.
 * @param {Camera} camera @param {ArrayLike<number>} point m @param {number} share of its depth */
export function onRay(camera, point, share) {
  return /** @type {Vector} */ (camera.centre.map((v, i) => v + share * (point[i] - v)));
}

/** The image of a camera's ray of a point, in another camera.
 * @param {Camera} into @param {Camera} from @param {ArrayLike<number>} point */
export function rayLine(into, from, point) {
  const [x, y] = projectPoint(into, point), [u, v] = projectPoint(into, onRay(from, point, 1.001));
  return through([x, y], [u, v]);
}

/** @param {ArrayLike<number>} p @param {ArrayLike<number>} q @returns {Line} */
export function through(p, q) {
  const dx = q[0] - p[0], dy = q[1] - p[1], length = Math.hypot(dx, dy), a = -dy / length, b = dx / length;
  return {a, b, c: -(a * p[0] + b * p[1])};
}

/** The angle between two lines, rad, at most a right one. @param {Line} first @param {Line} second */
export const angleBetween = (first, second) =>
  Math.asin(Math.min(1, Math.abs(first.a * second.b - second.a * first.b)));

/** Lines in two pictures by hand: parallel ones at an angle in each, with the spacing and the shift that fit the
 * matches best. The line of match i is where (b - first·s_i) of the second picture is 0.
 * @param {number[][]} first px, points in the first picture
 * @param {number[][]} second px, their matches in the second
 * @param {number} angle rad, of the lines in the first picture, clockwise from the right
 * @param {number} otherAngle rad, of those in the second
 * @returns {{first: Line[], second: Line[], left: number[], rms: number}} left: px from each point of the second
 * picture to its line, with a sign */
export function pencil(first, second, angle, otherAngle) {
  const n = [-Math.sin(angle), Math.cos(angle)], m = [-Math.sin(otherAngle), Math.cos(otherAngle)];
  const s = first.map(p => dot(n, p)), t = second.map(p => dot(m, p)), count = s.length;
  const mean = (/** @type {number[]} */ values) => values.reduce((sum, v) => sum + v, 0) / count, ms = mean(s);
  const mt = mean(t);
  const slope = dot(s.map(v => v - ms), t.map(v => v - mt)) / dot(s.map(v => v - ms), s.map(v => v - ms));
  const expected = s.map(v => mt + slope * (v - ms)), left = t.map((v, i) => v - expected[i]);
  return {
    first: s.map(v => ({a: n[0], b: n[1], c: -v})), second: expected.map(v => ({a: m[0], b: m[1], c: -v})),
    left, rms: Math.sqrt(dot(left, left) / count),
  };
}

/** The place on a link's point in the world.
 * @param {World} world @param {"demonstrator" | "learner"} who @param {number[]} theta @param {number} point */
export function placeOf(world, who, theta, point) {
  const {on, at} = world.body[point];
  return transform(world.arms[who].frames(theta)[on], at);
}

export const MARKS = ["a", "b", "c"]; // names of the three marks
const MARKED = [6, 7, 9]; // body points that are these marks
const STICK = [0.12, 0.06, 0.35]; // m, from the demonstrator's base to the mark on the stick
export const FIRST_SHARE = 0.5; // of the mark's depth: where its slide along the ray is nearest to camera 1
export const LAST_SHARE = 1.42; // where it is farthest
export const PLACES = [0.5, 0.65, 0.8, 0.92, 1.08, 1.24, 1.42]; // of the seven dots that it leaves
const [TURN_BACK, GO_HOME] = [0.22, 0.82]; // of the reveal: where the slide turns, first nearer, then away, then home
const DRAWN_FIRST = 0.1; // of the reveal: until then the ray is drawn

/** The view from outside: azimuth and elevation of the spectator, rad, and how many units of its marks a metre is. */
export const OUTSIDE = {azimuth: -0.42, elevation: 0.42, unit: 250};

/** @param {number} x m to the right @param {number} y m down @returns {[number, number]} a mark */
export const outsideMark = (x, y) => [x * OUTSIDE.unit, y * OUTSIDE.unit];

/** Axes of the view from outside in the world: to the right, down, towards the spectator. */
function outsideAxes() {
  const {azimuth, elevation} = OUTSIDE, [ca, sa] = [Math.cos(azimuth), Math.sin(azimuth)];
  const [ce, se] = [Math.cos(elevation), Math.sin(elevation)];
  return [[-sa, ca, 0], [se * ca, se * sa, -ce], [ce * ca, ce * sa, se]];
}

/** A point of the world in the view from outside, in the unit of its marks. @param {ArrayLike<number>} point */
export function seenFromOutside(point) {
  const [right, down] = outsideAxes();
  return outsideMark(dot(right, point), dot(down, point));
}

/** The mark on the stick, m. @param {World} world @returns {Vector} */
export function markOf(world) {
  const T = world.arms.demonstrator.T_world_base;
  return [T[3] + STICK[0], T[7] + STICK[1], T[11] + STICK[2]];
}

/** The three marks on the arm, m. @param {Stage} stage */
export const marksOf = stage => MARKED
  .map(point => placeOf(stage.world, "demonstrator", stage.moment.thetaDemo, point));

/** What both cameras move away from: the middle of the arm's points, m. @param {Stage} stage @returns {Vector} */
export function targetOf({world, moment}) {
  const points = world.body.map((_, i) => placeOf(world, "demonstrator", moment.thetaDemo, i));
  return /** @type {Vector} */ ([0, 1, 2].map(k => points.reduce((sum, p) => sum + p[k], 0) / points.length));
}

/** Cameras 1 and 2 as the slider `camera distance` has them.
 * @param {Stage} stage @param {number} [distance] times the usual one */
export function camerasOf(stage, distance = stage.sliders.get("camera distance") ?? 1) {
  const target = targetOf(stage);
  const {scene, world: {arms}} = stage; // the scene's cameras: the slider has moved the world's
  return twoCameras({scene, arms}).map(camera => distance === 1 ? camera : dollied(camera, target, distance));
}

/** The mark as it slides along its ray while the reveal is played: nearer, then away, then home.
 * @param {number} reveal 0 … 1 */
export function sliding(reveal) {
  const between = (/** @type {number} */ from, /** @type {number} */ to) =>
    smoothstep(Math.min(1, Math.max(0, (reveal - from) / (to - from))));
  const [near, far, home] = [between(DRAWN_FIRST, TURN_BACK), between(TURN_BACK, GO_HOME), between(GO_HOME, 1)];
  const away = FIRST_SHARE + far * (LAST_SHARE - FIRST_SHARE);
  const share = reveal < TURN_BACK ? 1 + near * (FIRST_SHARE - 1) : away + home * (1 - away);
  return {
    share, isMoving: reveal > 0 && reveal < 1,
    /** How far the line has been drawn, as a share of the mark's depth. */
    reached: reveal < TURN_BACK ? FIRST_SHARE : away,
    passed: (/** @type {number} */ place) => reveal >= TURN_BACK && away >= place - 1e-9,
  };
}

/** How far the mark would move in picture 1 if it were where a click in the view from outside has put it: as a click is
 * itself a ray, at the place on that which is nearest to the mark's ray.
 * @param {World} world @param {ArrayLike<number>} at a mark in the view from outside */
export function movedInPicture1(world, at) {
  const [right, down, towards] = outsideAxes(), [camera] = twoCameras(world), mark = markOf(world);
  const [u, v] = [at[0] / OUTSIDE.unit, at[1] / OUTSIDE.unit], from = right.map((r, i) => u * r + v * down[i]);
  const q = mark.map((m, i) => m - camera.centre[i]), w = from.map((p, i) => p - camera.centre[i]);
  const pq = dot(towards, q), qq = dot(q, q), s = (pq * dot(q, w) - qq * dot(towards, w)) / (qq - pq * pq);
  const [x, y] = projectPoint(camera, from.map((p, i) => p + s * towards[i])), [a, b] = projectPoint(camera, mark);
  return Math.hypot(x - a, y - b);
}
