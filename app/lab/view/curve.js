/** E after every step, on a logarithmic scale. */
import {add, energyText, px, set} from "./svg.js";

const PAD = {left: 4, top: 7, right: 8, bottom: 5}, MIN_STEPS = 8, MIN_E = 1e-3, LABEL_PX = 34, MAX_DOTS = 60;

export class Curve {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    this.svg = add(box, "svg", {class: "vi", role: "img"});
    this.last = "";
    this.width = 0;
    this.height = 0;
  }

  measure() {
    this.width = this.box.clientWidth;
    this.height = this.box.clientHeight;
    set(this.svg, {viewBox: `0 0 ${Math.max(this.width, 1)} ${Math.max(this.height, 1)}`});
    this.last = "";
  }

  /** @param {{E: number, probe: boolean, motion: number}[]} history */
  draw(history) {
    const {width, height} = this, now = history[history.length - 1], key = `${history.length} ${now.motion} ${now.E}`;
    if (key === this.last) return;
    this.last = key;
    set(this.svg, {"aria-label": `E after each of ${now.motion} steps`});
    const E = history.map(moment => Math.max(moment.E, MIN_E)), known = E.filter(Number.isFinite);
    if (!known.length || width < 80) return void this.svg.replaceChildren();
    const top = Math.max(...known), bottom = Math.min(...known), span = Math.max(Math.log(top / bottom), 1);
    const left = PAD.left + LABEL_PX, across = width - left - PAD.right, down = height - PAD.top - PAD.bottom;
    const x = (/** @type {number} */ k) => left + across * k / Math.max(MIN_STEPS, E.length - 1);
    const y = (/** @type {number} */ value) => PAD.top + down * Math.log(top / value) / span;
    let path = "", pen = "M";
    E.forEach((value, k) => {
      if (Number.isFinite(value)) path += `${pen}${px(x(k))} ${px(y(value))}`;
      pen = Number.isFinite(value) ? "L" : "M";
    });
    const probes = history.slice(0, -1).map(({probe}, k) => probe && E.length <= MAX_DOTS && Number.isFinite(E[k])
      ? `<circle class="vi-probe-E" cx="${px(x(k))}" cy="${px(y(E[k]))}" r="2.4"/>` : "").join("");
    const label = (/** @type {number} */ value) =>
      `<text class="vi-2nd vi-end" x="${left - 7}" y="${px(y(value) + 4)}">${energyText(value)}</text>`;
    const last = E.length - 1, here = Number.isFinite(E[last]) ? `<path class="vi-dot-E" d="M${px(x(last))} ${px(y(E[last]))}h0"/>` : "";
    this.svg.innerHTML = `<path class="vi-rule" d="M${left} ${height - 1}H${width - PAD.right}M${left} ${PAD.top}V${height - 1}"/>
${label(top)}${y(bottom) - y(top) > 13 ? label(bottom) : ""}<path class="vi-line-E" d="${path}"/>${probes}${here}`;
  }
}
