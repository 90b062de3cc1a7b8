/** A figure as text, for print and for browsers without script: its drawings as they are, its maps as SVG. */
import {contour} from "../view/map.js";
import {px} from "../view/svg.js";

let masks = 0;

/** @param {import("./frame.js").Frame} frame @param {string} name @returns {string} HTML */
export function stillOf(frame, name) {
  const copy = /** @type {HTMLElement} */ (frame.panels.cloneNode(true)), canvases = copy.querySelectorAll("canvas");
  frame.maps.forEach((map, k) => { canvases[k].outerHTML = groundOf(map, `${name}-${masks++}`); });
  for (const element of copy.querySelectorAll(".box")) for (const attribute of ["tabindex", "role", "aria-label"])
    element.removeAttribute(attribute);
  copy.querySelector(".facts")?.removeAttribute("aria-live");
  for (const empty of copy.querySelectorAll('path[d=""], [hidden]')) empty.remove();
  return copy.outerHTML;
}

/** The shading and the contours of a map: shades are a mask, so that their colour is that of the theme.
 * @param {import("../view/map.js").EnergyMap} map @param {string} id */
function groundOf(map, id) {
  const {rows, columns, levels} = map.drawn, {lower, upper} = map.range;
  const [left, top] = map.place([upper[0], lower[1]]), [right, bottom] = map.place([lower[0], upper[1]]);
  const [stepX, stepY] = [(right - left) / (columns - 1), (bottom - top) / (rows - 1)];
  const area = (/** @type {number} */ x, /** @type {number} */ y) => // with the same border on each side
    `x="${px(left - x)}" y="${px(top - y)}" width="${px(right - left + 2 * x)}" height="${px(bottom - top + 2 * y)}"`;
  const d = levels.map(level => {
    const parts = /** @type {string[]} */ ([]);
    const at = (/** @type {number} */ x, /** @type {number} */ y) =>
      `${px(left + x * stepX)} ${px(bottom - y * stepY)}`;
    contour(map.z, rows, columns, level, (x0, y0, x1, y1) => { parts.push(`M${at(x0, y0)}L${at(x1, y1)}`); });
    return parts.join("");
  }).join("");
  return `<svg class="vi" viewBox="0 0 ${px(map.width)} ${px(map.height)}" aria-hidden="true">
<mask id="${id}" style="mask-type:alpha">
<image ${area(stepX / 2, stepY / 2)} preserveAspectRatio="none" href="${map.image.toDataURL()}"/></mask>
<rect class="vi-hills" ${area(0, 0)} mask="url(#${id})"/><path class="vi-contour" d="${d}"/></svg>`;
}
