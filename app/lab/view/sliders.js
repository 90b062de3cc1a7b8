/** A slider for each joint: those of the demonstrator pose it, those of the learner show its goal as well. */
import {make} from "../lessons/dom.js";
import {DEGREE, fixed, say} from "./svg.js";

/** A slider of the learner, with its goal and the way there. */
const RAIL = '<span class="rail"><svg viewBox="0 0 100 22" preserveAspectRatio="none" aria-hidden="true"><path/></svg>'
  + '<input type="range"><s></s></span>';

export class Sliders {
  /** @param {HTMLElement} box @param {"demonstrator" | "learner"} who
   * @param {(joint: number, angle: number) => void} moved
   * @param {(held: boolean) => void} held whether a finger is on one of them */
  constructor(box, who, moved, held) {
    this.box = box;
    this.who = who;
    this.moved = moved;
    this.held = held;
    this.lower = /** @type {number[]} */ ([]);
    this.upper = /** @type {number[]} */ ([]);
    /** @type {{input: HTMLInputElement, output: HTMLElement, label: HTMLElement, gap: SVGPathElement | null}[]} */
    this.rows = [];
    this.busy = /** @type {HTMLInputElement | null} */ (null); // that a finger is on
  }

  /** @param {string[]} joints @param {number[]} lower @param {number[]} upper */
  build(joints, lower, upper) {
    this.lower = lower;
    this.upper = upper;
    this.box.replaceChildren();
    this.rows = joints.map((name, k) => {
      const symbol = name.split(" ").pop() ?? "", label = make("span", {class: "name"}, name.slice(0, -symbol.length), make("em", {}, symbol));
      const output = make("b", {class: "value"}), row = this.box.appendChild(make("label", {class: `joint of-${this.who}`,
        html: this.who === "learner" ? RAIL : '<input type="range">'}));
      row.prepend(label);
      row.append(output);
      const input = /** @type {HTMLInputElement} */ (row.querySelector("input"));
      Object.assign(input, {min: (lower[k] / DEGREE).toFixed(1), max: (upper[k] / DEGREE).toFixed(1), step: "0.5"});
      input.setAttribute("aria-label", `${name} of the ${this.who}`);
      input.addEventListener("input", () => {
        this.busy = input;
        this.moved(k, Number(input.value) * DEGREE);
      });
      input.addEventListener("pointerdown", () => this.held(true));
      for (const end of ["change", "pointerup", "pointercancel"]) input.addEventListener(end, () => {
        this.busy = null;
        this.held(false);
      });
      return {input, label, output, gap: row.querySelector("path")};
    });
  }

  /** They only show angles from now on. */
  lock() { for (const {input} of this.rows) input.disabled = true; }

  /** @param {number[]} theta @param {number[]} goal */
  show(theta, goal) {
    const {lower, upper} = this;
    /** @param {number[]} angles @param {number} k */
    const share = (angles, k) => (angles[k] - lower[k]) / (upper[k] - lower[k]);
    this.rows.forEach(({input, output, gap}, k) => {
      const text = `${fixed(theta[k] / DEGREE)}°`;
      if (this.busy !== input) input.value = String(theta[k] / DEGREE);
      input.style.setProperty("--at", `${100 * share(theta, k)}%`);
      input.setAttribute("aria-valuetext", `${(theta[k] / DEGREE).toFixed(1)} degrees`);
      say(output, text);
      if (!gap) return;
      /** @type {HTMLElement} */ (input.parentElement).style.setProperty("--goal", String(share(goal, k)));
      gap.setAttribute("d", `M${100 * share(theta, k)} 11H${100 * share(goal, k)}`);
    });
  }
}
