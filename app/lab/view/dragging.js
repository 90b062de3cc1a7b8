/** What a pointer takes hold of: points in the images, the learner's dot on the map, hands and elbows in the scene.
 * @import {Lab} from "./lab.js" @import {Who} from "./space.js" */
import {reachFor, transform} from "../engine/engine.js";
import {draggable, pulled, touchMap} from "./drag.js";
import {byId as $} from "./page.js";

const GRIP_PX = 30, HAND_PX = 8; // around what can be gripped in the scene, and by how much farther the hand can
const MOVED_PX = 4; // a drag is longer
const HAND_OFFSET = [0, 0, 0.1]; // m, from the last link's frame to between its fingers

/** @param {Lab} lab */
export function dragging(lab) {
  const hold = (/** @type {boolean} */ held) => lab.hold(held);
  draggable($("images"), event => gripPoint(lab, event), hold);
  $("images").addEventListener("click", (/** @type {PointerEvent} */ event) => {
    const hit = lab.isOpen && event.pointerType === "touch" ? lab.view.images.hit(event, lab.experiment.now) : null;
    if (hit) lab.choose(hit.point);
  });
  touchMap(lab.view.map, (box, begin) => draggable(box, begin, hold), {
    isOn: () => lab.isOpen, learner: () => posture(lab, "learner"), demonstrator: () => posture(lab, "demonstrator"),
    limits: () => lab.experiment.scene, place: theta => lab.place(theta), pose: theta => lab.pose(theta),
  });
  for (const box of [$("space"), $("still")]) draggable(box, event => gripArm(lab, event), hold);
  $("space").addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    if (!event.buttons) $("space").classList.toggle("over", lab.isOpen && Boolean(nearestGrip(lab, event)));
  });
}

/** @param {Lab} lab @param {Who} who */
const posture = (lab, who) => who === "learner" ? lab.experiment.now.theta : lab.experiment.now.thetaDemo;

/** @param {Lab} lab @param {Who} who @param {number[]} theta */
const move = (lab, who, theta) => who === "learner" ? lab.place(theta) : lab.pose(theta);

/** A point in an image. @param {Lab} lab @param {PointerEvent} event */
function gripPoint(lab, event) {
  const {images} = lab.view, {now, world} = lab.experiment, hit = lab.isOpen ? images.hit(event, now) : null;
  const isFinger = event.pointerType === "touch"; // its tap chooses, its swipe scrolls
  if (!hit || isFinger && hit.point !== lab.experiment.chosen) return null;
  lab.choose(hit.point);
  const who = hit.view < 2 ? "demonstrator" : "learner";
  const follow = pulled(world, images, hit, event, () => posture(lab, who), theta => move(lab, who, theta));
  let hasMoved = false;
  return (/** @type {PointerEvent} */ moved) => {
    hasMoved ||= Math.hypot(moved.clientX - event.clientX, moved.clientY - event.clientY) >= MOVED_PX;
    if (hasMoved) follow(moved);
  };
}

/** An arm in the scene. @param {Lab} lab @param {PointerEvent} event */
function gripArm(lab, event) {
  const hit = event.shiftKey || !lab.isOpen ? null : nearestGrip(lab, event);
  const {lower, upper} = lab.experiment.scene;
  return hit && ((/** @type {PointerEvent} */ {clientX, clientY}) => move(lab, hit.who, reachFor(hit.seen,
    [clientX - hit.box.left - hit.grip[0], clientY - hit.box.top - hit.grip[1]], posture(lab, hit.who), lower, upper)));
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
