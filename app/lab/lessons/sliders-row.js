/** The sliders of a step. They are in reach where something has to be done, and otherwise once it was answered.
 * @import {Stage, Slider} from "./stage.js" */
import {inline, letGo, make, track} from "./dom.js";
import {short} from "./measured.js";

const LOGARITHMIC_STEPS = 200, WHOLE = 1 - 1e-9; // so that rounding does not put the last step beyond the end
const ACTS = ["do", "pose", "predict"]; // kinds whose sliders are there before the answer

/** Whether the arm is moved step by step, by sliders that wait for Go. @param {Stage} stage */
export const isSteered = ({step: {ask}, isRevealed}) => ask.kind === "do" && Boolean(ask.counted) && !isRevealed;

/** Whether they are in reach. @param {Stage} stage */
export function areOpen(stage) {
  const {step, isRevealed} = stage;
  if (isSteered(stage)) return false;
  if (step.ask.kind === "pose" || step.ask.kind === "predict") return !isRevealed;
  return ACTS.includes(step.ask.kind) || isRevealed;
}

export class SlidersRow {
  /** @param {HTMLElement} box @param {Stage} stage
   * @param {(slider: Slider, value: number) => void} slid while it is dragged @param {() => void} released */
  constructor(box, stage, slid, released) {
    this.stage = stage;
    this.box = box;
    this.rows = (stage.step.sliders ?? []).map(slider => {
      const even = (/** @type {number} */ value) => slider.logarithmic ? Math.log(value) : value,
        {low, high, step = 1, logarithmic} = slider;
      const input = make("input", {type: "range", min: even(low), max: even(high), step: logarithmic
        ? (even(high) - even(low)) / LOGARITHMIC_STEPS * WHOLE : step, "aria-label": slider.label});
      const output = make("output", {});
      letGo(input);
      const value = () => Math.min(high, Math.max(low, logarithmic ? Math.exp(Number(input.value))
        : Number(input.value)));
      input.addEventListener("input", () => { slid(slider, value()); });
      input.addEventListener("change", () => { released(); });
      const kind = slider.name.startsWith("demo ") ? "of-demonstrator" : slider.name.startsWith("own ") ? "of-learner"
        : "of-other";
      const row = make("label", {class: `slider ${kind}`}, make("span", {class: "name", html: inline(slider.label)}),
        input, slider.unit === null ? null : output);
      box.append(row);
      return {slider, input, output, even};
    });
  }

  /** @param {boolean} isLocked */
  update(isLocked) {
    this.box.hidden = !this.rows.length || !areOpen(this.stage);
    for (const {slider, input, output, even} of this.rows) {
      const value = this.stage.sliders.get(slider.name) ?? slider.start;
      if (!input.matches(":active")) input.value = String(even(value));
      const shown = slider.logarithmic ? Math.exp(Number(input.value)) : Number(input.value);
      const words = `${slider.logarithmic ? short(shown) : Number(shown.toFixed(3))}${slider.unit ?? ""}`.replace("-",
        "−");
      output.textContent = words;
      if (slider.unit !== null) input.setAttribute("aria-valuetext", words);
      input.disabled = isLocked;
      track(input);
    }
  }
}
