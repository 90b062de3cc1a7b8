/**
 * The chosen point of l or r under a hand: dragged, or moved by the arrow keys. Its line in L goes with it.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").Mark} Mark
 */
import {draggable} from "../../view/drag.js";

const GRIP_PX = 30; // around the point
const KEY_PX = 1; // of the image, that a key moves it
const KEYS = /** @type {Record<string, [number, number]>} */ ({
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
});

/**
 * Let a view's point be dragged while the step has that layer.
 *
 * @param {{name: string, k: number, box: HTMLElement, place: (stage: Stage, mark: Mark) => [number, number],
 *   unplace: (stage: Stage, at: [number, number]) => Mark}} view
 * @param {Stage} stage
 * @returns {() => void} to be called when it is drawn: the box takes keys as soon as it can
 */
export function draggedIn(view, stage) {
  const {main = [], side = []} = stage.step, uses = [...main, ...side].filter(({figure}) => figure === view.name);
  const isIn = (/** @type {"show" | "reveal"} */ when) => uses.some(use => use[when]?.includes("draggable"));
  if (!isIn("show") && !isIn("reveal")) return () => {};
  const isOpen = () => isIn("show") || stage.isRevealed;
  const {box, k} = view, at = () => /** @type {Mark} */ ([...stage.pointed().subarray(2 * k, 2 * k + 2)]);
  const moveTo = (/** @type {Mark} */ place) => {
    const points = Float64Array.from(stage.pointed());
    points.set(place, 2 * k);
    stage.kept.set("dragged", points);
    stage.changed();
  };
  const under = (/** @type {PointerEvent} */ event) => {
    const frame = box.getBoundingClientRect();
    return /** @type {[number, number]} */ ([event.clientX - frame.left, event.clientY - frame.top]);
  };
  draggable(box, event => {
    if (!isOpen()) return null;
    const [x, y] = under(event), [a, b] = view.place(stage, at());
    if (Math.hypot(x - a, y - b) > GRIP_PX) return null;
    return moved => moveTo(view.unplace(stage, under(moved)));
  }, () => {});
  box.addEventListener("keydown", event => {
    const way = KEYS[event.key], [a, b] = at(), far = event.shiftKey ? 10 * KEY_PX : KEY_PX;
    if (!way || !isOpen()) return;
    event.preventDefault();
    event.stopPropagation();
    moveTo([a + far * way[0], b + far * way[1]]);
  });
  return () => {
    if (box.tabIndex === 0 || !isOpen()) return;
    box.classList.add("draggable");
    box.tabIndex = 0;
    box.setAttribute("role", "group");
    box.setAttribute("aria-label", `The marked point in ${view.name}. Arrow keys move it.`);
  };
}
