/** Dragging with a finger or a pointer, at most once a frame. A finger that takes hold of nothing scrolls the page.
 * @import {World} from "../engine/world.js" @import {Images} from "./images.js" @import {EnergyMap} from "./map.js" */
import {clamp, DEGREE, projectPoint, reachFor} from "../engine/engine.js";

const LARGE_STEP = 5; // by an arrow key, with Shift
const FINGER_PX = 24, POINTER_PX = 16, BESIDE_PX = 12; // around dots of a map

/** @param {HTMLElement | SVGElement} element
 * @param {(event: PointerEvent) => ((event: PointerEvent) => void) | null} begin what follows the pointer from here,
 * null for nothing @param {(held: boolean) => void} held */
export function draggable(element, begin, held) {
  let isHeld = false;
  // It comes after the pointer went down, and would scroll; while the page still scrolls it cannot be refused
  element.addEventListener("touchstart", event => {
    if (isHeld && event.cancelable) event.preventDefault();
  }, {passive: false});
  element.addEventListener("pointerdown", given => {
    const event = /** @type {PointerEvent} */ (given);
    const follow = event.isPrimary && event.button === 0 ? begin(event) : null;
    isHeld = Boolean(follow);
    if (!follow) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    element.setPointerCapture(event.pointerId);
    held(true);
    let last = /** @type {PointerEvent | null} */ (null);
    const move = (/** @type {Event} */ moved) => {
      if (!last) requestAnimationFrame(() => {
        if (last) follow(last);
        last = null;
      });
      last = /** @type {PointerEvent} */ (moved);
    };
    const end = () => {
      element.removeEventListener("pointermove", move);
      for (const name of ["pointerup", "pointercancel"]) element.removeEventListener(name, end);
      isHeld = false;
      held(false);
    };
    element.addEventListener("pointermove", move);
    for (const name of ["pointerup", "pointercancel"]) element.addEventListener(name, end);
  }, true);
}

/** Follow a body point of an arm under a pointer: the posture within the limits that brings the point there.
 * @param {World} world @param {Images} images @param {{view: number, point: number}} hit
 * @param {PointerEvent} event where it is gripped @param {() => number[]} posture of the arm
 * @param {(theta: number[]) => void} moved @returns {(event: PointerEvent) => void} */
export function pulled(world, images, {view, point}, event, posture, moved) {
  const who = view < 2 ? "demonstrator" : "learner", camera = world.scene.cameras[view], body = [world.body[point]];
  const seen = (/** @type {number[]} */ theta) => projectPoint(camera, world.arms[who].points(theta, body)).slice(0, 2);
  const from = seen(posture()), grip = images.under(event, view).map((v, k) => v - from[k]), {lower, upper} = world.scene;
  return next => moved(reachFor(seen, images.under(next, view).map((v, k) => v - grip[k]), posture(), lower, upper));
}

/** Arrow keys on an element, with Shift five times as far.
 * @param {HTMLElement} element @param {(right: number, up: number) => boolean | void} turn false where it does nothing */
export function arrowKeys(element, turn) {
  element.addEventListener("keydown", event => {
    const move = {ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowRight: [1, 0], ArrowLeft: [-1, 0]}[event.key];
    if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
    const by = event.shiftKey ? LARGE_STEP : 1;
    if (turn(move[0] * by, move[1] * by) === false) return;
    event.preventDefault();
    event.stopPropagation();
  });
}

/** What arrow keys make of a posture: up turns the first joint, right the second one.
 * @param {number[]} theta @param {number} right degrees @param {number} up degrees
 * @param {{lower: number[], upper: number[]}} limits */
export const turned = (theta, right, up, {lower, upper}) =>
  theta.map((v, k) => clamp(v + (k ? right : up) * DEGREE, lower[k], upper[k]));

/** Hands and keys on a map of E: the learner goes to any place, and the demonstrator's diamond where that may be moved.
 * @param {EnergyMap} map
 * @param {(box: HTMLElement, begin: (event: PointerEvent) => ((event: PointerEvent) => void) | null) => void} drag
 * @param {{isOn?: () => boolean, learner: () => number[], demonstrator: () => number[],
 * limits: () => {lower: number[], upper: number[]}, place: (theta: number[]) => void,
 * pose: ((theta: number[]) => void) | null}} acts pose: null where the demonstrator stays */
export function touchMap(map, drag, {isOn = () => true, learner, demonstrator, limits, place, pose}) {
  const {box} = map;
  drag(box, event => {
    if (!isOn()) return null;
    const room = box.getBoundingClientRect(), from = map.under(event, room); // to ask again would lay out the page
    const away = (/** @type {number[]} */ theta) => Math.hypot(...map.place(theta).map((v, k) => v - from[k]));
    const isFinger = event.pointerType === "touch", near = isFinger ? FINGER_PX : POINTER_PX;
    const isDemo = pose && away(demonstrator()) < near && away(learner()) > BESIDE_PX;
    if (isFinger && !isDemo && away(learner()) >= near) return null; // a tap places the learner, a swipe scrolls
    if (!isDemo) place(map.postureAt(event, room));
    return moved => isDemo ? pose(map.postureAt(moved, room)) : place(map.postureAt(moved, room));
  });
  box.addEventListener("click", given => {
    const event = /** @type {PointerEvent} */ (given);
    if (isOn() && event.pointerType === "touch") place(map.postureAt(event));
  });
  arrowKeys(box, (right, up) => isOn() && place(turned(learner(), right, up, limits())));
}
