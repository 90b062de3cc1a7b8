/** Keys of the whole page, but where something on it takes them for itself. */

import {byId} from "./page.js";

/** Elements that take arrow keys or the space bar for themselves, but only if keys focused them. */
const RETURNING = "input[type=radio], select, #space, #map, .buttons button";

/** Where somebody types: letters and Enter are the field's own. */
const TYPED_IN = `input:not(${["range", "radio", "checkbox", "button", "submit", "reset", "image", "file", "color"].map(type =>
  `[type=${type}]`).join()}), textarea, select`;

/** Whether a key is meant for the page: nobody types, no dialog is open, nothing has taken it. @param {KeyboardEvent} event */
export function isForPage({target, defaultPrevented, isComposing, ctrlKey, metaKey, altKey}) {
  return !(defaultPrevented || isComposing || ctrlKey || metaKey || altKey) && target instanceof Element
    && !target.closest(TYPED_IN) && !(target instanceof HTMLElement && target.isContentEditable)
    && !document.querySelector("dialog[open], :popover-open");
}

/** @param {Record<string, () => void>} keys what each does, letters in lower case @param {() => boolean} isOn */
export function listen(keys, isOn) {
  document.addEventListener("keydown", event => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, target = /** @type {Element} */ (event.target);
    if (!isForPage(event) || !isOn() || !(key in keys)) return;
    if (target.matches("input[type=radio], input[type=range]") && /^(Arrow|Home|End|Page)/.test(key)) return;
    if (key === " " && target.matches("button, summary, input[type=checkbox]")) return;
    event.preventDefault();
    keys[key]();
  });
}

/** @param {Record<string, () => void>} buttons what each does, by its id @param {() => boolean} isOn */
export function press(buttons, isOn) {
  for (const [id, act] of Object.entries(buttons)) byId(id).addEventListener("click", () => { if (isOn()) act(); });
}

/** What a pointer has chosen or dragged does not keep the focus: the keys of the page go on. */
export function returnFocus() {
  let isPointer = false;
  const giveBack = () => {
    const {activeElement} = document;
    if (isPointer && activeElement instanceof HTMLElement && activeElement.matches(RETURNING)) activeElement.blur();
  };
  const onPointer = (/** @type {boolean} */ is) => () => { isPointer = is; };
  document.addEventListener("pointerdown", onPointer(true), true);
  document.addEventListener("keydown", onPointer(false), true);
  document.addEventListener("change", giveBack);
  for (const end of ["pointerup", "click"]) document.addEventListener(end, ({target}) => {
    // The list of a select stays open until something is chosen
    if (!(target instanceof HTMLSelectElement)) setTimeout(giveBack);
  });
}
