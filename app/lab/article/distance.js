/** Why it is off: perspective, which fades as the eyes move back and zoom in. */
import {DEGREE, energyAt, farthest, lowest, recovered, World} from "../engine/engine.js";
import {Images} from "../view/images.js";
import {add, drawingUnit, energyText, fixed, px, set} from "../view/svg.js";
import {Ground} from "./ground.js";
import {sessionOf} from "./views.js";

/** @typedef {"arrow" | "shift"} Name
 * @typedef {{distance: number, arrow: number, shift: number}} Row distance: times the first; arrow: px; shift:
 * degrees */

const TIMES = [1, 2, 5, 10], PARTS = [1, 3, 10, 30]; // of the chart's axes
const NAMES = /** @type {const} */ (["arrow", "shift"]);
const POSE = [45 * DEGREE, -90 * DEGREE], STEP_RAD = DEGREE; // of the search for the lowest E

/** @type {import("./frame.js").FigureKind} */
export function distance(frame, data) {
  const images = new Images({L: frame.panel("L", "Picture <i>L</i>, in exactly the right pose")}, data.hulls);
  const rigs = data.distances.map(({value, cameras}) => {
    const world = new World({...data.turned, cameras}, 10), {now} = sessionOf(world, POSE, POSE);
    return {value, world, now, shift: NaN, lowest: POSE};
  });
  const box = frame.mapPanel("ground", "The map of E: cross and diamond",
    "Map of E: the cross is the lowest E, the diamond the demonstrator’s pose.");
  box.removeAttribute("tabindex");
  const ground = new Ground(frame, box, rigs[0].world);
  const chart = new Chart(frame.panel("chart", "Both against the distance"));
  let k = 0;
  const slider = frame.slider({
    label: "Distance of the eyes", low: 0, high: rigs.length - 1, step: 1, value: 0,
    text: at => `${fixed(rigs[at].value)} ×`, moved: at => go(at),
  });
  const go = (/** @type {number} */ at) => {
    k = at;
    ground.enter(rigs[k].world);
    images.fresh = true;
  };
  frame.button("Start again", () => {
    go(0);
    slider.show(0);
  });
  frame.hint.textContent = "Move the eyes back. They zoom in at the same time, so the arms stay about as large.";
  /** How far the lowest E is from the truth, in degrees. @param {typeof rigs[number]} rig */
  const shiftOf = rig => {
    if (Number.isNaN(rig.shift)) {
      const demo = rig.world.look("demonstrator", POSE);
      rig.lowest = lowest(theta => energyAt(rig.world, "epipolar", demo, theta), POSE, STEP_RAD, rig.world.scene);
      rig.shift = farthest(rig.lowest, POSE);
    }
    return rig.shift;
  };

  return {
    measure() {
      images.measure();
      ground.measure();
      chart.measure();
    },
    draw() {
      const {world, now, value} = rigs[k];
      images.draw(world, {moment: now, recovered: recovered(now), lines: [], chosen: 8, goal: false, ease: 1});
      ground.draw(POSE, POSE);
      chart.draw(rigs.map(rig => ({distance: rig.value, arrow: Math.sqrt(rig.now.E), shift: shiftOf(rig)})), k);
      frame.say(
        k ? `At ${fixed(value)} times the distance:` : "",
        `The arm stands exactly right, and E is <b>${energyText(now.E)} px²</b>.`,
        `A typical arrow is <b>${fixed(Math.sqrt(now.E), 2)} px</b> long.`,
        `The lowest E is <b>${fixed(shiftOf(rigs[k]), 2)}°</b> from the truth.`,
      );
    },
    state: () => ({distance: rigs[k].value, E: rigs[k].now.E, shift: shiftOf(rigs[k])}),
  };
}

/** Arrows, and the shift of the lowest E, over the distance, as shares of what they are at first. */
class Chart {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    this.width = 1;
    this.height = 1;
    const label = "Arrows, and the shift of the lowest E, over the distance";
    this.svg = add(box, "svg", {class: "vi", role: "img", "aria-label": label});
  }

  measure() {
    const unit = drawingUnit();
    [this.width, this.height] = [this.box.clientWidth / unit, this.box.clientHeight / unit];
    set(this.svg, {viewBox: `0 0 ${px(this.width)} ${px(this.height)}`});
  }

  /** @param {Row[]} rows @param {number} here */
  draw(rows, here) {
    const [left, top, right, bottom] = [38, 10, this.width - 16, this.height - 24];
    const share = (/** @type {Row} */ row, /** @type {Name} */ of) => row[of] / rows[0][of];
    const far = Math.log(rows[rows.length - 1].distance);
    const deep = Math.log(Math.min(...rows.map(row => share(row, "shift"))));
    const x = (/** @type {number} */ value) => left + (right - left) * Math.log(value) / far;
    const y = (/** @type {number} */ value) => top + (bottom - top) * Math.log(value) / deep;
    const at = (/** @type {Name} */ of) => (/** @type {Row} */ row) => {
      return `${px(x(row.distance))} ${px(y(share(row, of)))}`;
    };
    const ticks = TIMES.map(times => `<path class="vi-axis" d="M${px(x(times))} ${px(bottom)}v4"/>`
      + text("vi-2nd vi-mid", x(times), bottom + 17, `${times}×`));
    const levels = PARTS.filter(part => y(1 / part) <= bottom + 1).map(part =>
      `<path class="vi-rule" d="M${left} ${px(y(1 / part))}H${px(right)}"/>`
      + text("vi-2nd vi-end", left - 5, y(1 / part) + 4, part === 1 ? "1" : `1/${part}`));
    const named = rows[Math.round(rows.length * .6)], u = x(named.distance);
    const [arrow, shift] = NAMES.map(of => y(share(named, of)));
    this.svg.innerHTML = `${levels.join("")}${ticks.join("")}
<path class="vi-line-E" d="M${rows.map(at("arrow")).join("L")}"/>
<path class="vi-line-own" d="M${rows.map(at("shift")).join("L")}"/>
${text("vi-of-E vi-halo", u + 2, arrow - 8, "arrows")}${text("vi-of-own vi-halo vi-end", u - 4, shift + 14, "shift")}
<path class="vi-dot-E" d="M${at("arrow")(rows[here])}h0"/><path class="vi-dot-own" d="M${at("shift")(rows[here])}h0"/>`;
  }
}

/** @param {string} kind @param {number} x @param {number} y @param {string} words */
const text = (kind, x, y, words) => `<text class="${kind}" x="${px(x)}" y="${px(y)}">${words}</text>`;
