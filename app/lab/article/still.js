/** A figure as text, for print and for browsers without script: its drawings as they are, its maps as SVG. */
import {contour} from "../view/map.js";
import {px} from "../view/svg.js";

let masks = 0;

/** @param {import("./frame.js").Frame} frame @param {string} name @returns {string} HTML */
export function stillOf(frame, name) {
  const copy = /** @type {HTMLElement} */ (frame.panels.cloneNode(true)), canvases = copy.querySelectorAll("canvas");
  frame.maps.forEach((map, k) => { canvases[k].outerHTML = groundOf(map, `${name}-${masks++}`); });
  for (const element of copy.querySelectorAll("[tabindex]")) for (const attribute of ["tabindex", "role", "aria-label", "style"])
    element.removeAttribute(attribute);
  for (const empty of copy.querySelectorAll('path[d=""], [hidden]')) empty.remove();
  return copy.outerHTML;
}

/** The shading and the contours of a map: shades are a mask, so that their colour is that of the theme. @param {import("../view/map.js").EnergyMap} map @param {string} id */
function groundOf(map, id) {
  const {rows, columns, levels} = map.drawn, {lower, upper} = map.range;
  const [left, top] = map.place([upper[0], lower[1]]), [right, bottom] = map.place([lower[0], upper[1]]);
  const [stepX, stepY] = [(right - left) / (columns - 1), (bottom - top) / (rows - 1)];
  const place = `x="${px(left)}" y="${px(top)}" width="${px(right - left)}" height="${px(bottom - top)}"`;
  const all = `x="${px(left - stepX / 2)}" y="${px(top - stepY / 2)}" width="${px(right - left + stepX)}" height="${px(bottom - top + stepY)}"`;
  const d = levels.map(level => {
    /** @type {string[]} */
    const parts = [];
    contour(map.z, rows, columns, level, (x0, y0, x1, y1) => {
      parts.push(`M${px(left + x0 * stepX)} ${px(bottom - y0 * stepY)}L${px(left + x1 * stepX)} ${px(bottom - y1 * stepY)}`);
    });
    return joined(parts);
  }).join("");
  return `<svg class="vi" viewBox="0 0 ${px(map.width)} ${px(map.height)}" aria-hidden="true"><mask id="${id}" style="mask-type:alpha">\
<image ${all} preserveAspectRatio="none" href="${map.image.toDataURL()}"/></mask><rect class="vi-hills" ${place} mask="url(#${id})"/><path class="vi-contour" d="${d}"/></svg>`;
}

/** Spans that begin where others end, in as few strokes as they make. @param {string[]} parts each of "Mx yLx y" */
function joined(parts) {
  /** @type {Map<string, string[]>} spans by their ends */
  const at = new Map(), spans = parts.map(part => part.slice(1).split("L")).filter(([a, b]) => a !== b);
  const used = new Set();
  spans.forEach((ends, k) => ends.forEach(end => at.set(end, [...at.get(end) ?? [], String(k)])));
  const next = (/** @type {string} */ end) => (at.get(end) ?? []).map(Number).find(k => !used.has(k));
  let d = "";
  spans.forEach((span, first) => {
    if (used.has(first)) return;
    used.add(first);
    const stroke = [...span];
    for (const isBack of [false, true]) for (let k = next(stroke[isBack ? 0 : stroke.length - 1]); k !== undefined; k = next(stroke[isBack ? 0 : stroke.length - 1])) {
      used.add(k);
      const end = stroke[isBack ? 0 : stroke.length - 1], other = spans[k][0] === end ? spans[k][1] : spans[k][0];
      if (isBack) stroke.unshift(other);
      else stroke.push(other);
    }
    d += `M${stroke.join("L")}`;
  });
  return d;
}
