/** E after every step, on a logarithmic scale, and the joints' angles.
 * @typedef {{E: number, probe: boolean, motion: number}} Step */
import {add, DEGREE, energyText, fixed, polyline, px, set} from "./svg.js";

const PAD = {left: 4, top: 7, right: 8, bottom: 5}, MIN_STEPS = 8, MIN_E = 1e-3, LABEL_PX = 34, MAX_DOTS = 60;
const ROOM_PX = 13; // between two labels
const MIN_DEG = 20; // that the plot of angles spans at least

/** A plot over the motions of a run, as wide as its box. */
class Plot {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.svg = add(box, "svg", {class: "vi", role: "img"});
    this.box = box;
    this.last = "";
    this.width = 0;
    this.height = 0;
    /** Motions of its first and last step, and px of the first and of one motion. */
    this.axis = {from: 0, to: 0, left: 0, each: 1};
  }

  measure() {
    this.width = this.box.clientWidth;
    this.height = this.box.clientHeight;
    set(this.svg, {viewBox: `0 0 ${Math.max(this.width, 1)} ${Math.max(this.height, 1)}`});
    this.last = "";
  }

  /** The motion under a pointer. @param {{clientX: number}} pointer */
  motionAt({clientX}) {
    const {from, left, each} = this.axis;
    return from + (clientX - this.box.getBoundingClientRect().left - left) / each;
  }

  /** @param {number[]} motions @param {number} right px that stay free */
  span(motions, right) {
    const from = motions[0], to = motions[motions.length - 1], left = PAD.left + LABEL_PX;
    this.axis = {from, to, left, each: (this.width - left - right) / Math.max(MIN_STEPS, to - from)};
    return motions.map(motion => left + (motion - from) * this.axis.each);
  }

  /** Axes, and a line at a motion that is not the last. @param {number} right @param {number | null} now px */
  frame(right, now) {
    const {width, height, axis: {left}} = this, cursor = `M${px(now ?? 0)} ${PAD.top}V${height - 1}`;
    return `<path class="vi-rule" d="M${left} ${height - 1}H${width - right}M${left} ${PAD.top}V${height - 1}"/>
${now === null ? "" : `<path class="vi-cursor" d="${cursor}"/>`}`;
  }

  /** @param {string} text @param {number} y */
  label(text, y) {
    return `<text class="vi-2nd vi-end" x="${this.axis.left - 7}" y="${px(y + 4)}">${text}</text>`;
  }
}

export class Curve extends Plot {
  /** @param {Step[]} history @param {number} [at] index of the step that is shown, the last one by default
   * @param {number | null} [least] E in the demonstrator's posture, px²: a line */
  draw(history, at = history.length - 1, least = null) {
    const {width, height} = this, now = history[at], key = [history.length, now.motion, now.E, at, least].join(" ");
    if (key === this.last) return;
    this.last = key;
    set(this.svg, {"aria-label": `E after each of ${now.motion} steps, on a logarithmic scale`});
    const E = history.map(moment => Math.max(moment.E, MIN_E)), known = E.filter(Number.isFinite);
    if (!known.length || width < 80) return void this.svg.replaceChildren();
    const all = least === null ? known : [...known, Math.max(least, MIN_E)];
    const top = Math.max(...all), bottom = Math.min(...all), scale = Math.max(Math.log(top / bottom), 1);
    const down = height - PAD.top - PAD.bottom, xs = this.span(history.map(({motion}) => motion), PAD.right);
    const y = (/** @type {number} */ value) => PAD.top + down * Math.log(top / value) / scale;
    const places = E.map((value, k) => [xs[k], y(value)]);
    const line = (/** @type {number} */ from, /** @type {number} */ to) => polyline(places.slice(from, to + 1));
    const probes = history.slice(0, -1).map(({probe}, k) => probe && E.length <= MAX_DOTS && Number.isFinite(E[k])
      ? `<circle class="vi-probe-E" cx="${px(xs[k])}" cy="${px(y(E[k]))}" r="2.4"/>` : "").join("");
    const labels = (all.length > 1 ? [top, top / Math.exp(scale)] : [top]).map(E => this.label(energyText(E), y(E))).join("")
      + (all.length > 1 && height > 3 * ROOM_PX ? this.label("log", height / 2) : "");
    const rest = at < E.length - 1 ? `<path class="vi-line-E vi-later" d="${line(at, E.length - 1)}"/>` : "";
    const truth = least === null ? ""
      : `<path class="vi-line-demo" d="M${this.axis.left} ${px(y(Math.max(least, MIN_E)))}H${width - PAD.right}"/>`;
    const here = Number.isFinite(E[at]) ? `<path class="vi-dot-E" d="M${px(xs[at])} ${px(y(E[at]))}h0"/>` : "";
    this.svg.innerHTML = `${this.frame(PAD.right, rest ? xs[at] : null)}${truth}
${labels}${rest}<path class="vi-line-E" d="${line(0, at)}"/>${probes}${here}`;
  }
}

/** The learner's angles, and dashed those of the demonstrator. */
export class Angles extends Plot {
  /** @param {{motion: number, theta: number[], thetaDemo: number[]}[]} history @param {number} at
   * @param {string[]} symbols of the joints */
  draw(history, at, symbols) {
    const key = `${history.length} ${at}`;
    if (key === this.last) return;
    this.last = key;
    const {width, height} = this, right = 34, now = history[at];
    set(this.svg, {"aria-label": `Angles of ${symbols.join(", ")} after each step; dashed: the demonstrator's`});
    if (width < 80) return void this.svg.replaceChildren();
    const all = history.flatMap(({theta, thetaDemo}) => [...theta, ...thetaDemo].map(v => v / DEGREE));
    const low = Math.min(...all), high = Math.max(...all, low + MIN_DEG), down = height - PAD.top - PAD.bottom;
    const xs = this.span(history.map(({motion}) => motion), right);
    const y = (/** @type {number} */ rad) => PAD.top + down * (high - rad / DEGREE) / (high - low);
    /** @param {string} kind @param {(one: typeof now) => number} of @param {number} [from] @param {number} [to] */
    const line = (kind, of, from = 0, to = history.length - 1) =>
      `<path class="${kind}" d="${polyline(history.map((one, k) => [xs[k], y(of(one))]).slice(from, to + 1))}"/>`;
    const taken = /** @type {number[]} */ ([]);
    const parts = symbols.map((symbol, j) => {
      const end = y(history[history.length - 1].theta[j]);
      const isFree = taken.every(other => Math.abs(other - end) > ROOM_PX);
      if (isFree) taken.push(end);
      const place = `x="${px(xs[xs.length - 1] + 6)}" y="${px(end + 4)}"`;
      const name = isFree ? `<text class="vi-of-own" ${place}>${symbol}</text>` : "";
      return line("vi-line-demo", one => one.thetaDemo[j]) + line("vi-line-own vi-later", one => one.theta[j], at)
        + line("vi-line-own", one => one.theta[j], 0, at) + name
        + `<path class="vi-dot-own" d="M${px(xs[at])} ${px(y(now.theta[j]))}h0"/>`;
    });
    const labels = [high, low].map(v => this.label(`${fixed(v, 0)}°`, y(v * DEGREE))).join("");
    this.svg.innerHTML = this.frame(right, at < history.length - 1 ? xs[at] : null) + labels + parts.join("");
  }
}
