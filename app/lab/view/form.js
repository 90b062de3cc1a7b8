/** The lab's fields: what can be tried, how the learner learns, and what spoils its pictures.
 * @import {Lab} from "./lab.js" */
import {beginning} from "./address.js";
import {byId as $} from "./page.js";
import {fixed, say} from "./svg.js";
import {SERVO_WORDS, TRANSFER_WORDS} from "./words.js";

export class Form {
  /** @param {Lab} lab */
  constructor(lab) {
    this.lab = lab;
    for (const {title, name} of lab.experiment.offered.presets) $("preset").add(new Option(title, name));
    $("preset").addEventListener("change", () => this.#enterPreset());
    radios($("servo"), "servo", SERVO_WORDS, servo => lab.setServo(servo));
    radios($("transfer"), "transfer", TRANSFER_WORDS, transfer => lab.restart({transfer}));
    const value = (/** @type {string} */ id) => Number($(id).value);
    $("noise").addEventListener("input", () => lab.restart({noisePx: value("noise")}));
    $("lost").addEventListener("input", () => lab.restart({missing: value("lost") / 100}));
    $("seed").addEventListener("input", () => {
      if ($("seed").value && $("seed").validity.valid) lab.restart({seed: value("seed")});
    });
    $("seed").addEventListener("change", () => this.fill());
    $("points").addEventListener("change", () => lab.restart({points: value("points")}));
    for (const id of ["goal", "rays"]) $(id).addEventListener("change", () => lab.redraw());
  }

  /** What the fields say, of the present state. */
  fill() {
    const {state, scene, misread, preset} = this.lab.experiment, {servo, transfer, noisePx, missing, seed} = state;
    $("preset").value = state.preset;
    check("servo", servo, SERVO_WORDS);
    check("transfer", transfer, TRANSFER_WORDS);
    const wrong = misread.length ? `This link asks for what the lab does not have: ${misread.join(", ")}.` : "";
    $("says").classList.toggle("misread", Boolean(wrong));
    say($("says"), wrong || this.#changed() || preset.says);
    $("noise").value = noisePx;
    $("lost").value = 100 * missing;
    if (Number($("seed").value) !== seed || !$("seed").value) $("seed").value = seed;
    say($("noise").nextElementSibling, `${fixed(noisePx)} px`);
    say($("lost").nextElementSibling, `${(100 * missing).toFixed(0)} %`);
    $("points").replaceChildren(...Object.keys(scene.layouts).map(count => new Option(count, count)));
    $("points").value = state.points;
    for (const id of ["noise", "lost"]) $(id).style.setProperty("--at", `${100 * $(id).value / $(id).max}%`);
  }

  /** @param {string} id of a checkbox */
  toggle(id) {
    $(id).checked = !$(id).checked;
    this.lab.redraw();
  }

  nextPreset() {
    $("preset").selectedIndex = ($("preset").selectedIndex + 1) % $("preset").length;
    this.#enterPreset();
  }

  #enterPreset() {
    const {presets, scenes} = this.lab.experiment.offered, chosen = presets[$("preset").selectedIndex];
    this.lab.enter({...beginning(chosen, scenes[chosen.scene]), point: this.lab.experiment.state.point});
  }

  /** What differs from the preset, in words. */
  #changed() {
    const {preset, state} = this.lab.experiment, {points, servo, transfer, noisePx, missing} = state;
    const differs = [
      points !== preset.points && `${points} points`,
      servo !== preset.servo && `law “${SERVO_WORDS[servo].title}”`,
      transfer !== preset.transfer && `transfer “${TRANSFER_WORDS[transfer].title}”`,
      noisePx !== preset.noisePx && `noise of ${fixed(noisePx)} px`,
      missing !== preset.missing && `${fixed(100 * missing, 0)} % of the points lost`,
    ].filter(Boolean);
    return differs.length ? `The same scene, but with ${differs.join(", ")}.` : "";
  }
}

/** @typedef {Record<string, {title: string, says: string}>} Words of choices, by their values */

/** @param {HTMLElement} box @param {string} name @param {Words} words @param {(value: string) => void} chosen */
function radios(box, name, words, chosen) {
  for (const [value, {title}] of Object.entries(words)) {
    const label = box.appendChild(document.createElement("label"));
    label.innerHTML = `<input type="radio" name="${name}" value="${value}"><span>${title}</span>`;
    label.querySelector("input")?.addEventListener("change", () => chosen(value));
  }
}

/** @param {string} name @param {string} value @param {Words} words */
function check(name, value, words) {
  const input = document.querySelector(`input[name=${name}][value=${value}]`);
  if (input instanceof HTMLInputElement) input.checked = true;
  say($(`${name}-says`), words[value].says);
}
