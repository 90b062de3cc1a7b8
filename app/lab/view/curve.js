/** E after every step, on a logarithmic scale. */
import {energyText, px, set} from "./svg.js";

const PAD = {left: 4, top: 7, right: 8, bottom: 5}, MIN_STEPS = 8, FLOOR = 1e-3, LABEL_PX = 34;

/**
 * @param {HTMLElement} box
 * @param {{E: number, probe: boolean}[]} history
 */
export function drawCurve(box, history) {
  const width = box.clientWidth, height = box.clientHeight;
  const svg = box.querySelector("svg") ?? box.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "svg"));
  set(svg, {class: "vi", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `E after each of ${history.length - 1} steps`});
  const E = history.map(moment => Math.max(moment.E, FLOOR)), known = E.filter(Number.isFinite);
  if (!known.length || width < 80) return void svg.replaceChildren();
  const top = Math.max(...known), bottom = Math.min(...known), span = Math.max(Math.log(top / bottom), 1);
  const left = PAD.left + LABEL_PX, across = width - left - PAD.right, down = height - PAD.top - PAD.bottom;
  const x = (/** @type {number} */ k) => left + across * k / Math.max(MIN_STEPS, E.length - 1);
  const y = (/** @type {number} */ value) => PAD.top + down * Math.log(top / value) / span;
  let path = "", pen = "M";
  E.forEach((value, k) => {
    if (!Number.isFinite(value)) { pen = "M"; return; }
    path += `${pen}${px(x(k))} ${px(y(value))}`;
    pen = "L";
  });
  const dots = E.length > 60 ? "" : history.slice(0, -1).map(({probe}, k) => !Number.isFinite(E[k]) ? "" : probe
    ? `<circle class="vi-probe-E" cx="${px(x(k))}" cy="${px(y(E[k]))}" r="2.4"/>` : "").join("");
  const last = E.length - 1, label = (/** @type {number} */ value) =>
    `<text class="vi-2nd vi-end" x="${left - 7}" y="${px(y(value) + 4)}">${energyText(value)}</text>`;
  svg.innerHTML = `<path class="vi-rule" d="M${left} ${height - 1}H${width - PAD.right}M${left} ${PAD.top}V${height - 1}"/>
${label(top)}${y(bottom) - y(top) > 13 ? label(bottom) : ""}<path class="vi-line-E" d="${path}"/>${dots}${Number.isFinite(E[last]) ? `<path class="vi-dot-E" d="M${px(x(last))} ${px(y(E[last]))}h0"/>` : ""}`;
}
