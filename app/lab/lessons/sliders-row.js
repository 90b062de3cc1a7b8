/** The sliders of a step. They are in reach where something has to be done, and otherwise once it was answered.
 * @import {Stage, Slider} from "./stage.js" */
import {inline, make, slider} from "./dom.js";
import {short} from "./measured.js";

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
    this.rows = (stage.step.sliders ?? []).map(one => {
      const {name, label, step = 1, unit} = one, output = make("output", {});
      const {input, read, show} = slider({...one, step}, value => slid(one, value), released);
      const kind = name.startsWith("demo ") ? "of-demonstrator" : name.startsWith("own ") ? "of-learner" : "of-other";
      box.append(make("label", {class: `slider ${kind}`}, make("span", {class: "name", html: inline(label)}), input,
        unit === null ? null : output));
      return {slider: one, input, output, read, show};
    });
  }

  /** @param {boolean} isLocked */
  update(isLocked) {
    this.box.hidden = !this.rows.length || !areOpen(this.stage);
    for (const {slider: {name, start, logarithmic, unit}, input, output, read, show} of this.rows) {
      const value = input.matches(":active") ? read() : this.stage.sliders.get(name) ?? start;
      const words = `${logarithmic ? short(value) : Number(value.toFixed(3))}${unit ?? ""}`.replace("-", "−");
      output.textContent = words;
      show(value, unit === null ? "" : words, isLocked);
    }
  }
}
