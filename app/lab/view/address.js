/**
 * The state of the lab in the address, to be read by people: #preset=paper&demo=45,-90&start=25,-25&law=broyden.
 *
 * @typedef {Object} Preset
 * @property {string} name
 * @property {string} title
 * @property {string} says
 * @property {string} scene
 * @property {number} points
 * @property {string} transfer
 * @property {string} servo
 * @property {number} noisePx
 * @property {number} missing
 * @property {number} seed
 *
 * @typedef {Object} State the page follows from it
 * @property {string} preset
 * @property {number[]} demonstrator rad
 * @property {number[]} start rad
 * @property {number} points
 * @property {string} transfer
 * @property {string} servo
 * @property {number} noisePx
 * @property {number} missing
 * @property {number} seed
 * @property {number} steps that were made
 * @property {number} [point] that the visitor chose
 */
import {clamp} from "../engine/engine.js";
import {SERVO_WORDS, TRANSFER_WORDS} from "./words.js";

const DEGREE = Math.PI / 180, MAX_STEPS = 3000;
const FIELDS = ["preset", "demo", "start", "law", "transfer", "points", "noise", "lost", "seed", "steps", "point", "back"];

/** @param {Preset} preset @param {import("../engine/world.js").Scene} scene @returns {State} */
export function beginning(preset, scene) {
  const {name, points, transfer, servo, noisePx, missing, seed} = preset;
  const {demonstrator, start} = scene;
  return {preset: name, points, transfer, servo, noisePx, missing, seed, demonstrator, start, steps: 0};
}

/**
 * Read an address; what it does not say, or says wrongly, is as in the preset.
 *
 * @param {string} hash
 * @param {Preset[]} presets
 * @param {Record<string, import("../engine/world.js").Scene>} scenes
 * @param {string[]} [wrong] where what it says wrongly is added
 * @returns {State}
 */
export function fromAddress(hash, presets, scenes, wrong = []) {
  const asked = new URLSearchParams(hash.replace(/^#/, ""));
  const preset = presets.find(({name}) => name === asked.get("preset")) ?? presets[0];
  const scene = scenes[preset.scene], state = beginning(preset, scene);
  const checked = (/** @type {string} */ name, /** @type {boolean} */ isRight) => {
    if (asked.has(name) && !isRight) wrong.push(`${name}=${asked.get(name)}`);
    return isRight;
  };
  for (const name of asked.keys()) if (name && !FIELDS.includes(name)) checked(name, false);
  checked("preset", preset.name === asked.get("preset"));
  /** @param {string} name @param {number} usual @param {number} low @param {number} high */
  const number = (name, usual, low, high) => {
    const value = Number(asked.get(name) || NaN);
    return checked(name, value >= low && value <= high) || Number.isFinite(value) ? clamp(value, low, high) : usual;
  };
  const posture = (/** @type {string} */ name, /** @type {number[]} */ usual) => {
    const angles = (asked.get(name) ?? "").split(",").map(text => text ? Number(text) * DEGREE : NaN);
    return checked(name, angles.length === usual.length && angles.every(Number.isFinite))
      ? angles.map((v, k) => clamp(v, scene.lower[k], scene.upper[k])) : usual;
  };
  const choice = (/** @type {string} */ name, /** @type {string} */ usual, /** @type {object} */ choices) => {
    const value = asked.get(name) ?? "";
    return checked(name, Object.hasOwn(choices, value)) ? value : usual;
  };
  const points = Number(choice("points", String(state.points), scene.layouts));
  const point = Number(asked.get("point") || NaN);
  const exists = Number.isInteger(point) && point >= 0 && point < scene.layouts[points].length;
  return {
    preset: preset.name,
    demonstrator: posture("demo", state.demonstrator),
    start: posture("start", state.start),
    points,
    transfer: choice("transfer", state.transfer, TRANSFER_WORDS),
    servo: choice("law", state.servo, SERVO_WORDS),
    noisePx: number("noise", state.noisePx, 0, 20),
    missing: number("lost", 100 * state.missing, 0, 100) / 100,
    seed: Math.round(number("seed", state.seed, 0, 2 ** 32 - 1)),
    steps: Math.round(number("steps", 0, 0, MAX_STEPS)),
    point: checked("point", exists) ? point : undefined,
  };
}

/**
 * The address of a state, without the values that are those of the preset.
 *
 * @param {State} state
 * @param {Preset} preset
 * @param {import("../engine/world.js").Scene} scene
 */
export function toAddress(state, preset, scene) {
  const usual = beginning(preset, scene);
  const degrees = (/** @type {number[]} */ angles) => angles.map(v => Number((v / DEGREE).toFixed(2))).join();
  const parts = [`preset=${state.preset}`, `demo=${degrees(state.demonstrator)}`, `start=${degrees(state.start)}`];
  if (state.servo !== usual.servo) parts.push(`law=${state.servo}`);
  if (state.transfer !== usual.transfer) parts.push(`transfer=${state.transfer}`);
  if (state.points !== usual.points) parts.push(`points=${state.points}`);
  if (state.noisePx !== usual.noisePx) parts.push(`noise=${state.noisePx}`);
  if (state.missing !== usual.missing) parts.push(`lost=${Number((100 * state.missing).toFixed(3))}`);
  if (state.seed !== usual.seed) parts.push(`seed=${state.seed}`);
  if (Number(state.point) < scene.layouts[state.points].length) parts.push(`point=${state.point}`);
  if (state.steps) parts.push(`steps=${state.steps}`);
  return `#${parts.join("&")}`;
}
