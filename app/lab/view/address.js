/** The state of the lab in the address, to be read by people: #preset=paper&demo=45,-90&steps=3&demo=50,-80.
 * It is read from left to right: what stands behind `steps` happens at that moment, as in the links of viewimit's page.
 * @typedef {{name: string, title: string, says: string, scene: string, points: number, transfer: string, servo:
 * string, noisePx: number, missing: number, seed: number, start?: number[]}} Preset start: rad; the scene's if it is
 * not given
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
 * @property {number} steps that were made, up to the first move of the demonstrator
 * @property {{demonstrator: number[], steps: number}[]} [later] its moves, rad, and the steps after each
 * @property {number} [point] that the visitor chose */
import {clamp, DEGREE} from "../engine/engine.js";
import {SERVO_WORDS, TRANSFER_WORDS} from "./words.js";

const MAX_STEPS = 3000, MAX_MOVES = 500;
const VALUES = /** @type {const} */ ([["servo", "servo"], ["transfer", "transfer"], ["points", "points"], ["noisePx", "noise"],
  ["missing", "missing"], ["seed", "seed"]]); // of a state, and their names in an address
const FIELDS = ["preset", "demo", "start", "servo", "transfer", "points", "noise", "missing", "seed", "steps", "point", "back"];

/** @param {Preset} preset @param {import("../engine/world.js").Scene} scene @returns {State} */
export function beginning(preset, scene) {
  const {name, points, transfer, servo, noisePx, missing, seed} = preset;
  const {demonstrator} = scene, start = preset.start ?? scene.start;
  return {preset: name, points, transfer, servo, noisePx, missing, seed, demonstrator, start, steps: 0};
}

/** Read an address; what it does not say, or says wrongly, is as in the preset.
 * @param {string} hash @param {Preset[]} presets @param {Record<string, import("../engine/world.js").Scene>} scenes
 * @param {string[]} [wrong] where what it says wrongly is added @returns {State} */
export function fromAddress(hash, presets, scenes, wrong = []) {
  const asked = /** @type {Map<string, string>} */ (new Map());
  const later = /** @type {string[][]} */ ([]);
  for (const [name, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    if (!name) continue;
    const isLater = asked.has("steps") && (name === "demo" || name === "steps");
    if (isLater && later.length < 2 * MAX_MOVES) later.push([name, text]);
    else if (!FIELDS.includes(name) || asked.has(name)) wrong.push(`${name}=${text}`);
    else asked.set(name, text);
  }
  const preset = presets.find(({name}) => name === asked.get("preset")) ?? presets[0];
  const scene = scenes[preset.scene], state = beginning(preset, scene);
  const checked = (/** @type {string} */ name, /** @type {boolean} */ isRight, text = asked.get(name)) => {
    if (text !== undefined && !isRight) wrong.push(`${name}=${text}`);
    return isRight;
  };
  checked("preset", preset.name === asked.get("preset"));
  /** @param {string} name @param {number} usual @param {number} low @param {number} high */
  const number = (name, usual, low, high, text = asked.get(name)) => {
    const value = Number(text || NaN);
    return checked(name, value >= low && value <= high, text) || Number.isFinite(value) ? clamp(value, low, high) : usual;
  };
  const posture = (/** @type {string} */ name, /** @type {number[]} */ usual, text = asked.get(name)) => {
    const angles = (text ?? "").split(",").map(word => word ? Number(word) * DEGREE : NaN);
    return checked(name, angles.length === usual.length && angles.every(Number.isFinite), text)
      ? angles.map((v, k) => clamp(v, scene.lower[k], scene.upper[k])) : usual;
  };
  const choice = (/** @type {string} */ name, /** @type {string} */ usual, /** @type {object} */ choices) => {
    const value = asked.get(name) ?? "";
    return checked(name, Object.hasOwn(choices, value)) ? value : usual;
  };
  const points = Number(choice("points", String(state.points), scene.layouts));
  const point = Number(asked.get("point") || NaN);
  const exists = Number.isInteger(point) && point >= 0 && point < scene.layouts[points].length;
  const steps = Math.round(number("steps", 0, 0, MAX_STEPS)), demonstrator = posture("demo", state.demonstrator);
  const moves = /** @type {NonNullable<State["later"]>} */ ([]);
  let left = MAX_STEPS - steps;
  for (const [name, text] of later) {
    const last = moves[moves.length - 1];
    if (name === "demo") moves.push({demonstrator: posture("demo", last?.demonstrator ?? demonstrator, text), steps: 0});
    else if (!last || last.steps) wrong.push(`steps=${text}`);
    else left -= last.steps = Math.round(number("steps", 0, 0, left, text));
  }
  return {
    preset: preset.name,
    demonstrator,
    start: posture("start", state.start),
    points,
    transfer: choice("transfer", state.transfer, TRANSFER_WORDS),
    servo: choice("servo", state.servo, SERVO_WORDS),
    noisePx: number("noise", state.noisePx, 0, 20),
    missing: number("missing", state.missing, 0, 1),
    seed: Math.round(number("seed", state.seed, 0, 2 ** 32 - 1)),
    steps,
    later: moves,
    point: checked("point", exists) ? point : undefined,
  };
}

/** Angles as people read them; the lab's own have no more digits. @param {number[]} angles rad */
export const inDegrees = angles => angles.map(v => Number((v / DEGREE).toFixed(2))).join();

/** The fields of a state, without the values that are those of the preset.
 * @param {State} state @param {Partial<State>} [usual] */
export const fieldsOf = (state, usual = {}) => [
  `demo=${inDegrees(state.demonstrator)}`, `start=${inDegrees(state.start)}`,
  ...VALUES.filter(([field]) => state[field] !== usual[field]).map(([field, name]) => `${name}=${state[field]}`),
];

/** What was done since the beginning, as fields. @param {State} state */
export function actionsOf({steps, later = []}) {
  const first = steps || later.length ? [`steps=${steps}`] : [];
  return [...first, ...later.flatMap(move => [`demo=${inDegrees(move.demonstrator)}`, ...move.steps ? [`steps=${move.steps}`] : []])];
}

/** The address of a state, without the values that are those of the preset.
 * @param {State} state @param {Preset} preset @param {import("../engine/world.js").Scene} scene */
export function toAddress(state, preset, scene) {
  const point = Number(state.point) < scene.layouts[state.points].length ? [`point=${state.point}`] : [];
  return `#${[`preset=${state.preset}`, ...fieldsOf(state, beginning(preset, scene)), ...point, ...actionsOf(state)].join("&")}`;
}

/** The address at which the page of viewimit opens in the lab's state: a query that it reads as it reads its own.
 * @param {State} state
 * @param {string} scene as the page's settings name it: a shipped one, or the text of a scene file
 * @param {string[]} layouts of body points that the scene has there */
export function pageLink(state, scene, layouts) {
  const points = layouts.includes(String(state.points)) ? state.points : Math.min(...layouts.map(Number));
  return ["preset=paper", `scene=${encodeURIComponent(scene)}`, ...fieldsOf({...state, points}),
    "frames=1", "rectify=off", ...actionsOf(state)].join("&");
}
