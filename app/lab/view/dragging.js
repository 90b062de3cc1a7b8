/** What a pointer takes hold of: points in the images, the learner's dot on the map, hands and elbows in the scene. */
import {projectPoint, reachFor, transform} from "../engine/engine.js";
import {draggable} from "./drag.js";
import {byId as $} from "./page.js";

/** @import {Lab} from "./lab.js" @import {Who} from "./space.js" */

const DEGREE = Math.PI / 180, LARGE_STEP = 5; // degrees by an arrow key, with Shift
const GRIP_PX = 30, HAND_PX = 8; // around what can be gripped in the scene, and by how much farther the hand can
const FINGER_PX = 24, POINTER_PX = 16, BESIDE_PX = 12, MOVED_PX = 4; // around dots of the map; a drag is longer
const HAND_OFFSET = [0, 0, 0.1]; // m, from the last link's frame to between its fingers

/** @param {Lab} lab */
export function dragging(lab) {
  const hold = (/** @type {boolean} */ held) => lab.hold(held);
  draggable($("images"), event => gripPoint(lab, event), hold);
  $("images").addEventListener("click", (/** @type {PointerEvent} */ event) => {
    const hit = lab.isOpen && event.pointerType === "touch" ? lab.view.images.hit(event, lab.experiment.now) : null;
    if (hit) lab.choose(hit.point);
  });
  draggable($("map"), event => gripDot(lab, event), hold);
  $("map").addEventListener("click", (/** @type {PointerEvent} */ event) => {
    if (lab.isOpen && event.pointerType === "touch") lab.place(lab.view.map.postureAt(event));
  });
  $("map").addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const turns = {ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1]}[event.key];
    if (!turns || !lab.isOpen) return;
    event.preventDefault();
    event.stopPropagation();
    const {now, scene: {lower, upper}} = lab.experiment, by = (event.shiftKey ? LARGE_STEP : 1) * DEGREE;
    lab.place(now.theta.map((v, k) => Math.min(upper[k], Math.max(lower[k], v + turns[k] * by))));
  });
  for (const box of [$("space"), $("still")]) draggable(box, event => gripArm(lab, event), hold);
  $("space").addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    if (!event.buttons) $("space").classList.toggle("over", lab.isOpen && Boolean(nearestGrip(lab, event)));
  });
}

/** @param {Lab} lab @param {Who} who */
const posture = (lab, who) => who === "learner" ? lab.experiment.now.theta : lab.experiment.now.thetaDemo;

/** Bring something of an arm to a target.
 * @param {Lab} lab @param {Who} who @param {(theta: number[]) => number[]} seen @param {number[]} target */
function reach(lab, who, seen, target) {
  const {scene: {lower, upper}} = lab.experiment, theta = reachFor(seen, target, posture(lab, who), lower, upper);
  if (who === "learner") lab.place(theta);
  else lab.pose(theta);
}

/** A point in an image. @param {Lab} lab @param {PointerEvent} event */
function gripPoint(lab, event) {
  const {images} = lab.view, {now, scene, world} = lab.experiment, hit = lab.isOpen ? images.hit(event, now) : null;
  const isFinger = event.pointerType === "touch"; // its tap chooses, its swipe scrolls
  if (!hit || isFinger && hit.point !== lab.experiment.chosen) return null;
  lab.choose(hit.point);
  const who = /** @type {Who} */ (hit.view < 2 ? "demonstrator" : "learner");
  const camera = scene.cameras[hit.view], point = [world.body[hit.point]];
  const seen = (/** @type {number[]} */ theta) =>
    projectPoint(camera, world.arms[who].points(theta, point)).slice(0, 2);
  const from = seen(posture(lab, who)), grip = images.under(event, hit.view).map((v, k) => v - from[k]);
  let hasMoved = false;
  return (/** @type {PointerEvent} */ moved) => {
    hasMoved ||= Math.hypot(moved.clientX - event.clientX, moved.clientY - event.clientY) >= MOVED_PX;
    if (hasMoved) reach(lab, who, seen, images.under(moved, hit.view).map((v, k) => v - grip[k]));
  };
}

/** A dot of the map, or any place on it. @param {Lab} lab @param {PointerEvent} event */
function gripDot(lab, event) {
  if (!lab.isOpen) return null;
  const {map} = lab.view, {theta, thetaDemo} = lab.experiment.now, box = $("map").getBoundingClientRect();
  const at = map.under(event, box); // the box stays the same: to ask again would lay out the page in every frame
  const away = (/** @type {number[]} */ of) => Math.hypot(...map.place(of).map((v, k) => v - at[k]));
  const isFinger = event.pointerType === "touch", near = isFinger ? FINGER_PX : POINTER_PX, isOwn = away(theta) < near;
  const isDemo = away(thetaDemo) < near && away(theta) > BESIDE_PX;
  if (isFinger && !isDemo && !isOwn) return null; // a tap places the learner, a swipe scrolls
  if (!isDemo) lab.place(map.postureAt(event, box));
  return (/** @type {PointerEvent} */ moved) =>
    isDemo ? lab.pose(map.postureAt(moved, box)) : lab.place(map.postureAt(moved, box));
}

/** An arm in the scene. @param {Lab} lab @param {PointerEvent} event */
function gripArm(lab, event) {
  const hit = event.shiftKey || !lab.isOpen ? null : nearestGrip(lab, event);
  return hit && ((/** @type {PointerEvent} */ {clientX, clientY}) =>
    reach(lab, hit.who, hit.seen, [clientX - hit.box.left - hit.grip[0], clientY - hit.box.top - hit.grip[1]]));
}

/** What of an arm can be gripped here: the hand, or the origin of a link that a joint moves.
 * @param {Lab} lab @param {PointerEvent} event */
function nearestGrip(lab, event) {
  const {view, experiment: {scene, world}} = lab;
  const box = $("space").getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
  const links = scene.links.flatMap(({on}, link) => on > 0 ? [link] : []), hand = links[links.length - 1];
  let best = null, least = GRIP_PX;
  for (const who of /** @type {const} */ (["demonstrator", "learner"])) for (const link of links) {
    const seen = (/** @type {number[]} */ theta) =>
      view.place(transform(world.arms[who].linkFrames(theta)[link], link === hand ? HAND_OFFSET : [0, 0, 0]));
    const at = seen(posture(lab, who)), away = Math.hypot(at[0] - x, at[1] - y) - (link === hand ? HAND_PX : 0);
    if (away < least) [least, best] = [away, {who, seen, grip: [x - at[0], y - at[1]], box}];
  }
  return best;
}
