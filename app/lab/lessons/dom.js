/** Elements, and the words of lessons as HTML. */

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

/** @param {string} text */
export const escaped = text => text.replace(/[&<>"]/g, c =>
  ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c] ?? c);

/** Whether a finger is what points here. */
export const isTouched = () => matchMedia("(pointer: coarse)").matches;

/** "Tap" for "Click" where fingers point. @param {string} words */
export const touched = words => isTouched() ? words.replace(/\bClick\b/g, "Tap").replace(/\bclick\b/g,
  "tap").replace(/\bpress\b/g, "tap") : words;

/** A measure that nothing has filled in is a dash. @param {string} words */
const unbraced = words => words.replace(/\{[^{}]*\}/g, "–");

/** Words with **bold**; a bold term of the glossary explains itself.
 * @param {string} words @param {Record<string, string>} [glossary] */
export const inline = (words, glossary = {}) => escaped(unbraced(touched(words))).replaceAll("'", "’").replace(
  /\*\*(.+?)\*\*/g,
  (_, bold) => {
  const key = Object.keys(glossary).find(term => term.toLowerCase() === bold.toLowerCase()
    || `${term.toLowerCase()}s` === bold.toLowerCase());
  return key ? `<b class="term" role="button" tabindex="0" data-term="${key}" aria-expanded="false">${bold}</b>`
    : `<b>${bold}</b>`;
});

/** Words without marks, to be read aloud. @param {string} words */
export const plain = words => unbraced(touched(words)).replaceAll("**", "");

/** A slider that was dragged gives its focus back, so that arrow keys go on with the lesson; one that was reached by
 * keys keeps it.
 * @param {HTMLInputElement} input of a range */
export function letGo(input) {
  input.addEventListener("pointerdown", () => {
    const end = () => {
      for (const name of ["pointerup", "pointercancel"]) removeEventListener(name, end, true);
      setTimeout(() => input.blur());
    };
    for (const name of ["pointerup", "pointercancel"]) addEventListener(name, end, true);
  });
}

/** @param {HTMLInputElement} input of a range: how far it stands, for the colour of its track */
export function track(input) {
  const low = Number(input.min), high = Number(input.max);
  input.style.setProperty("--at", `${100 * (Number(input.value) - low) / (high - low || 1)}%`);
}
