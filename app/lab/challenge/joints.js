/** Sliders that move nothing until Go, which turns all joints at once, and the glide of what is played. */
import {make} from "../lessons/dom.js";
import {DEGREE, smoothstep} from "../view/svg.js";

const STILL = 1e-9; // rad that a joint is not moved
const still = typeof matchMedia === "undefined" ? {matches: true} : matchMedia("(prefers-reduced-motion: reduce)");

/** Play something from 0 to 1, or show its end at once where nothing may move.
 * @param {number} lasts ms @param {(share: number) => void} frame @param {() => void} over
 * @returns {() => void} goes to its end */
export function play(lasts, frame, over) {
  const start = performance.now();
  let isOver = false;
  const end = () => {
    if (isOver) return;
    isOver = true;
    frame(1);
    over();
  };
  const next = () => {
    if (isOver) return;
    const share = (performance.now() - start) / lasts;
    if (share >= 1) return end();
    frame(share);
    requestAnimationFrame(next);
  };
  if (still.matches || lasts <= 0) end();
  else next();
  return end;
}

/** Postures on the way from one to another. @param {number[]} from @param {number[]} to @param {number} share */
export const between = (from, to, share) => from.map((v, k) => share < 1 ? v + smoothstep(share) * (to[k] - v) : to[k]);

/** A slider for each joint, and Go. A slider says its share of the range, and never degrees. */
export class Joints {
  /** @param {HTMLElement} box @param {{name: string, low: number, high: number}[]} joints rad
   * @param {(theta: number[]) => void} go @param {...HTMLElement} beside Go */
  constructor(box, joints, go, ...beside) {
    this.target = /** @type {number[]} */ ([]); // where the sliders stand, and the arm, rad
    this.stands = /** @type {number[]} */ ([]);
    this.isLocked = this.isMoving = false;
    this.button = make("button", {type: "button", class: "filled go", onclick: () => this.#go(go)}, "Go");
    this.rows = joints.map(({name, low, high}, k) => {
      const degrees = Math.round((high - low) / DEGREE), mark = make("s", {"aria-hidden": true});
      const input = make("input", {type: "range", min: 0, max: 100, step: 100 / degrees * (1 - STILL), "aria-label": name});
      input.addEventListener("input", () => this.#setTarget(k, low + Math.round(Number(input.value) / 100 * degrees) * DEGREE));
      input.addEventListener("keydown", event => {
        if (event.key !== "Enter") return;
        event.preventDefault();
        event.stopPropagation();
        this.#go(go);
      });
      const nudge = (/** @type {number} */ by) => make("button", {type: "button", class: "nudge", tabindex: -1,
        "aria-hidden": true, onclick: () => this.#setTarget(k, Math.min(high, Math.max(low, this.target[k] + by * DEGREE)))},
      by < 0 ? "−" : "+");
      box.append(make("div", {class: "turned of-learner"}, make("span", {class: "name"}, name), nudge(-1),
        make("span", {class: "rail"}, input, mark), nudge(1)));
      return {input, mark, share: (/** @type {number} */ angle) => (angle - low) / (high - low)};
    });
    box.append(make("div", {class: "goes"}, this.button, ...beside));
  }

  /** Set a slider, as a finger does. @param {number} k @param {number} angle rad */
  #setTarget(k, angle) {
    if (this.isLocked) return;
    this.target[k] = angle;
    this.#show();
  }

  get #isReady() {
    return !this.isLocked && !this.isMoving && this.target.some((v, k) => Math.abs(v - this.stands[k]) > STILL);
  }

  /** @param {(theta: number[]) => void} go */
  #go(go) { if (this.#isReady) go([...this.target]); }

  /** The arm stands somewhere; a slider that was not set goes with it.
   * @param {number[]} theta rad @param {boolean} isMoving whether the arm is on its way
   * @param {boolean} [isLocked] whether nothing can be set any more */
  show(theta, isMoving, isLocked = false) {
    this.isMoving = isMoving;
    this.target = theta.map((v, k) => this.target[k] === this.stands[k] ? v : this.target[k]);
    this.stands = [...theta];
    this.isLocked = isLocked;
    this.#show();
  }

  /** Forget what was set. */
  reset() { this.target = this.stands = []; }

  #show() {
    this.rows.forEach(({input, mark, share}, k) => {
      const percent = 100 * share(this.target[k]), moves = Math.abs(this.target[k] - this.stands[k]) > STILL;
      if (Math.abs(Number(input.value) - percent) > 1e-3) input.value = String(percent);
      input.disabled = this.isLocked;
      input.setAttribute("aria-valuetext", `${Math.round(percent)} percent of its range${moves ? ", not moved yet" : ""}`);
      input.style.setProperty("--at", `${percent}%`);
      mark.style.setProperty("--goal", String(share(this.stands[k])));
    });
    this.button.setAttribute("aria-disabled", String(!this.#isReady));
  }
}
