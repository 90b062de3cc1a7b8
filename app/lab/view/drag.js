/** Dragging with a finger or a pointer, at most once a frame. A finger that takes hold of nothing scrolls the page. */

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
    /** @type {PointerEvent | null} */
    let last = null;
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
