/** Why it is off: perspective, which fades as the eyes move back and zoom in. */
import {solve} from "../engine/algebra.js";
import {clamp, conflict, recovered, residual, TRANSFERS, World} from "../engine/engine.js";
import {Images} from "../view/images.js";
import {add, drawingUnit, energyText, fixed, px, set} from "../view/svg.js";
import {DEGREE} from "./frame.js";
import {Ground} from "./ground.js";
import {sessionOf} from "./views.js";

const POSE = [45 * DEGREE, -90 * DEGREE], ROUNDS = 8;
const DIFFERENCE_RAD = .25 * DEGREE, MAX_SHARE = 20; // of difference quotients; the longest step in these

/** @type {import("./frame.js").FigureKind} */
export function distance(frame, data) {
  const boxes = {L: frame.panel("L", "Picture <i>L</i>, in exactly the right pose")}, images = new Images(boxes, data.hulls);
  const rigs = data.distances.map(({value, cameras}) => {
    const world = new World({...data.turned, cameras}, 10), {now} = sessionOf(world, POSE, POSE);
    return {value, world, now, shift: NaN, lowest: POSE};
  });
  const box = frame.mapPanel("ground", "The map of E: cross and diamond", "Map of E: the cross is the lowest E, the diamond the demonstrator’s pose.");
  box.removeAttribute("tabindex");
  const ground = new Ground(frame, box, rigs[0].world), chart = new Chart(frame.panel("chart", "Both against the distance"));
  let k = 0;
  const slider = frame.slider({
    label: "Distance of the eyes", low: 0, high: rigs.length - 1, step: 1, value: 0, text: at => `${fixed(rigs[at].value)} ×`,
    moved: at => go(at),
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
      rig.lowest = lowest(rig.world);
      rig.shift = Math.max(...rig.lowest.map((v, i) => Math.abs(v - POSE[i]))) / DEGREE;
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
      frame.say(`The arm stands exactly right, and E is <b>${energyText(now.E)} px²</b>: a typical arrow is <b>${fixed(Math.sqrt(now.E), 2)} px</b>. The lowest E is <b>${fixed(shiftOf(rigs[k]), 2)}°</b> from the truth${k ? `, at ${fixed(value)} times the distance` : ""}.`);
    },
    state: () => ({distance: rigs[k].value, E: rigs[k].now.E, shift: shiftOf(rigs[k])}),
  };
}

/** The posture near the demonstrator's in which E is lowest, by Newton's method. @param {World} world of two moving joints */
function lowest(world) {
  const demo = world.look("demonstrator", POSE).images, {fit} = TRANSFERS.epipolar, h = DIFFERENCE_RAD;
  const E = (/** @type {number} */ first, /** @type {number} */ second) => {
    const own = world.look("learner", [first, second]).images;
    return conflict(residual(fit(demo, own), demo, own));
  };
  let [a, b] = POSE;
  for (let round = 0; round < ROUNDS; round++) {
    const here = E(a, b), [right, left, up, down] = [E(a + h, b), E(a - h, b), E(a, b + h), E(a, b - h)];
    const mixed = (E(a + h, b + h) - E(a + h, b - h) - E(a - h, b + h) + E(a - h, b - h)) / 4;
    const step = solve([[right + left - 2 * here, mixed], [mixed, up + down - 2 * here]], [(left - right) / 2, (down - up) / 2]);
    [a, b] = [a + h * clamp(step[0], -MAX_SHARE, MAX_SHARE), b + h * clamp(step[1], -MAX_SHARE, MAX_SHARE)];
  }
  return [a, b];
}

/** Arrows and the shift of the minimum against the distance, both as shares of what they are at first, on logarithmic scales. */
class Chart {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    this.width = 1;
    this.height = 1;
    this.svg = add(box, "svg", {class: "vi", role: "img", "aria-label": "Arrows and shift of the minimum against the distance"});
  }

  measure() {
    const unit = drawingUnit();
    [this.width, this.height] = [this.box.clientWidth / unit, this.box.clientHeight / unit];
    set(this.svg, {viewBox: `0 0 ${px(this.width)} ${px(this.height)}`});
  }

  /** @param {{distance: number, arrow: number, shift: number}[]} rows @param {number} here */
  draw(rows, here) {
    const [left, top, right, bottom] = [38, 10, this.width - 16, this.height - 24], far = Math.log(rows[rows.length - 1].distance);
    const deepest = Math.log(Math.min(...rows.map(({shift}) => shift / rows[0].shift)));
    const x = (/** @type {number} */ value) => left + (right - left) * Math.log(value) / far;
    const y = (/** @type {number} */ share) => top + (bottom - top) * Math.log(share) / deepest;
    const path = (/** @type {"arrow" | "shift"} */ name) => `M${rows.map(row => `${px(x(row.distance))} ${px(y(row[name] / rows[0][name]))}`).join("L")}`;
    const ticks = [1, 2, 5, 10].map(value => `<path class="vi-axis" d="M${px(x(value))} ${px(bottom)}v4"/><text class="vi-2nd vi-mid" x="${px(x(value))}" y="${px(bottom + 17)}">${value}×</text>`);
    const levels = [1, 1 / 3, 1 / 10, 1 / 30].filter(share => y(share) <= bottom + 1).map(share =>
      `<path class="vi-rule" d="M${left} ${px(y(share))}H${px(right)}"/><text class="vi-2nd vi-end" x="${left - 5}" y="${px(y(share) + 4)}">${share === 1 ? "1" : `1/${Math.round(1 / share)}`}</text>`);
    const now = rows[here], dots = /** @type {const} */ (["arrow", "shift"]).map(name =>
      `<path class="${name === "arrow" ? "vi-dot-E" : "vi-dot-own"}" d="M${px(x(now.distance))} ${px(y(now[name] / rows[0][name]))}h0"/>`);
    const middle = rows[Math.round(rows.length * .6)];
    const name = (/** @type {"arrow" | "shift"} */ of, /** @type {string} */ kind, /** @type {string} */ text, /** @type {number} */ up) =>
      `<text class="${kind} vi-halo${up > 0 ? "" : " vi-end"}" x="${px(x(middle.distance) + (up > 0 ? 2 : -4))}" y="${px(y(middle[of] / rows[0][of]) + (up > 0 ? -8 : 14))}">${text}</text>`;
    this.svg.innerHTML = `${levels.join("")}${ticks.join("")}<path class="vi-line-E" d="${path("arrow")}"/><path class="vi-line-own" d="${path("shift")}"/>
${name("arrow", "vi-of-E", "arrows", 1)}${name("shift", "vi-of-own", "shift", -1)}${dots.join("")}`;
  }
}
