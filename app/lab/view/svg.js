/** SVG elements whose attributes are rewritten in place, numbers as text, and the pace of what moves. */
export {DEGREE} from "../engine/algebra.js";

const NAMESPACE = "http://www.w3.org/2000/svg";

/** @template {keyof SVGElementTagNameMap} K @param {Element} within @param {K} tag
 * @param {Record<string, string | number>} [attributes] @returns {SVGElementTagNameMap[K]} */
export function add(within, tag, attributes = {}) {
  const made = document.createElementNS(NAMESPACE, tag);
  set(made, attributes);
  within.append(made);
  return made;
}

/** @param {Element} element @param {Record<string, string | number>} attributes those that differ are written */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes))
    if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
}

/** @param {Element} element @param {string} text */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Text as HTML has it. @param {string} text */
export const escaped = text => text.replace(/[&<>"]/g, sign => `&#${sign.charCodeAt(0)};`);

/** With a real minus. @param {number} value @param {number} [digits] */
export const fixed = (value, digits = 1) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1").replace("-", "−");

/** E in as many digits as it takes. @param {number} E */
export const energyText = E => Number.isNaN(E) ? "–" : E >= 100 ? fixed(E, 0) : fixed(E, E < 10 ? 2 : 1);

/** For a path. @param {number} value */
export const px = value => value.toFixed(1);

/** How many px a drawing's unit is: its marks and letters grow with the page's own. */
export const drawingUnit = () => Math.max(1, parseFloat(getComputedStyle(document.documentElement).fontSize) / 15);

/** The size of a drawing that fills its box.
 * @param {{clientWidth: number, clientHeight: number}} box
 * @returns {{unit: number, width: number, height: number}} px of a unit; units */
export function drawingSize({clientWidth, clientHeight}) {
  const unit = drawingUnit();
  return {unit, width: Math.max(clientWidth, 40) / unit, height: Math.max(clientHeight, 40) / unit};
}

/** The share of a way that begins and ends at rest (smoothstep). @param {number} share of the time */
export const smoothstep = share => share * share * (3 - 2 * share);

/** Data of a path through points; one that is not finite parts it. @param {number[][]} points */
export function polyline(points) {
  let d = "", pen = "M";
  for (const [x, y] of points) {
    const isThere = Number.isFinite(x) && Number.isFinite(y);
    if (isThere) d += `${pen}${px(x)} ${px(y)}`;
    pen = isThere ? "L" : "M";
  }
  return d;
}

/** @param {number[][]} points */
export const dots = points => points.map(([x, y]) => `M${px(x)} ${px(y)}h0`).join("");

/** @param {number[][]} points @param {number} r half a diagonal */
export const diamonds = (points, r) =>
  points.map(([x, y]) => `M${px(x - r)} ${px(y)}l${r}-${r} ${r} ${r}-${r} ${r}z`).join("");

/** @param {number[][]} points @param {number} r */
export const circles = (points, r) => points.map(([x, y]) =>
  `M${px(x - r)} ${px(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`).join("");

/** Upright crosses. @param {number[][]} points @param {number} r */
export const crosses = (points, r) =>
  points.map(([x, y]) => `M${px(x - r)} ${px(y)}h${2 * r}m-${r}-${r}v${2 * r}`).join("");

/** Data of the shafts of arrows and of their tips, which short ones lack.
 * @param {number[][][]} ends @param {number} most length of a tip @returns {[string, string]} */
export function arrowPaths(ends, most) {
  let shafts = "", tips = "";
  for (const [[a, b], [c, d]] of ends) {
    const length = Math.hypot(c - a, d - b), head = Math.min(most, length * .6);
    if (!(length > 0)) continue; // NaN, or nothing to draw
    const [u, v] = [(c - a) / length * head, (d - b) / length * head], back = length > most ? .7 : 0;
    shafts += `M${px(a)} ${px(b)}L${px(c - u * back)} ${px(d - v * back)}`;
    if (length > 3) tips += `M${px(c)} ${px(d)}L${px(c - u - v / 2)} ${px(d - v + u / 2)}L${px(c - u + v / 2)} ${px(d - v - u / 2)}z`;
  }
  return [shafts, tips];
}
