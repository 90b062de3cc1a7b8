/** Elements, and the words of lessons as HTML. */
import {escaped} from "../view/svg.js";

const SCALE_STEPS = 200, WHOLE = 1 - 1e-9; // of a scale; so that rounding does not put the last step beyond the end
const SURE_MS = 5000; // in which a second press means it

/** @template {keyof HTMLElementTagNameMap} K @param {K} tag
 * @param {Record<string, any>} [properties] `class`, `aria-…` and `data-…` are attributes, `on…` listeners, `html`
 * its inside @param {...(Node | string | null | undefined | false)} children @returns {HTMLElementTagNameMap[K]} */
export function make(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === "html") made.innerHTML = value;
    else if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children.filter(child => child !== null && child !== undefined && child !== false).map(child =>
    /** @type {Node | string} */ (child)));
  return made;
}

/** @param {string} words @param {() => void} act @param {string} [kind] its class */
export const button = (words, act, kind = "plain") => make("button", {type: "button", class: kind, onclick: act}, words);

/** A button that asks back, and acts at a second press soon after. @param {string} words @param {() => void} act */
export function confirming(words, act) {
  let timer = 0;
  const forgets = () => { timer = 0; made.textContent = words; };
  const made = button(words, () => {
    const sure = timer !== 0;
    clearTimeout(timer);
    timer = sure ? 0 : window.setTimeout(forgets, SURE_MS);
    made.textContent = sure ? words : `${words}: sure?`;
    if (sure) act();
  });
  return made;
}

/** An answer to press, with its key. @param {string} key @param {string} html @param {() => void} take @param {...Node} more */
export const option = (key, html, take, ...more) => make("button", {type: "button", class: "option", onclick: take},
  make("kbd", {"aria-hidden": true}, key), make("span", {html}), ...more);

/** Whether a finger is what points here. */
export const isTouched = () => matchMedia("(pointer: coarse)").matches;

/** "Tap" for "Click" where fingers point. @param {string} words */
export const touched = words => isTouched() ? words.replace(/\bClick\b/g, "Tap").replace(/\bclick\b/g,
  "tap").replace(/\bpress\b/g, "tap") : words;

/** A measure that nothing has filled in is a dash. @param {string} words */
const unbraced = words => words.replace(/\{[^{}]*\}/g, "–");

/** Words with **bold**, and with names of pictures as the pictures have them: a plain l reads as I. A bold term of the
 * glossary explains itself.
 * @param {string} words @param {Record<string, string>} [glossary] */
export const inline = (words, glossary = {}) => escaped(unbraced(touched(words))).replaceAll("'", "’").replace(
  /(?<![\w’-])[lrLR](?![\w’-])/g, eye => `<i class="eye">${eye}</i>`).replace(/\*\*(.+?)\*\*/g, (_, bold) => {
  const key = Object.keys(glossary).find(term => term.toLowerCase() === bold.toLowerCase()
    || `${term.toLowerCase()}s` === bold.toLowerCase());
  return key ? `<b class="term" role="button" tabindex="0" data-term="${key}" aria-expanded="false">${bold}</b>`
    : `<b>${bold}</b>`;
});

/** Words without marks, to be read aloud. @param {string} words */
export const plain = words => unbraced(touched(words)).replaceAll("**", "");

/** A slider, on a logarithmic scale if asked for. One that was dragged gives its focus back, so that arrow keys go on with
 * the page; one that was reached by keys keeps it.
 * @param {{label: string, low: number, high: number, step?: number | null, logarithmic?: boolean}} range
 * @param {(value: number) => void} moved @param {() => void} [released] */
export function slider({label, low, high, step, logarithmic}, moved, released) {
  const [first, last] = logarithmic ? [Math.log(low), Math.log(high)] : [low, high];
  const each = step && !logarithmic ? step : (last - first) / SCALE_STEPS * WHOLE;
  const input = make("input", {type: "range", min: first, max: last, step: each, "aria-label": label});
  const read = () => Math.min(high, Math.max(low, logarithmic ? Math.exp(Number(input.value)) : Number(input.value)));
  const end = () => {
    for (const name of ["pointerup", "pointercancel"]) removeEventListener(name, end, true);
    setTimeout(() => input.blur());
  };
  input.addEventListener("input", () => moved(read()));
  input.addEventListener("change", () => released?.());
  input.addEventListener("pointerdown", () => {
    for (const name of ["pointerup", "pointercancel"]) addEventListener(name, end, true);
  });
  return {
    input, read,
    /** @param {number} value @param {string} words that a screen reader says @param {boolean} [isLocked] */
    show(value, words, isLocked = false) {
      const at = logarithmic ? Math.log(value) : value;
      if (!input.matches(":active") && Number(input.value) !== at) input.value = String(at);
      if (words) input.setAttribute("aria-valuetext", words);
      input.disabled = isLocked;
      input.style.setProperty("--at", `${100 * (Number(input.value) - first) / (last - first || 1)}%`);
    },
  };
}
