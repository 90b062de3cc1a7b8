/** A recorded run, as app/lab/recording.py writes it: its snapshots as the lab's modules take them. */
import {EpipolarGeometry, MIN_POINTS, select} from "../engine/engine.js";

/** @typedef {{axes: number[], turn: number[], angle?: number[], steps?: number[][], lines?: number[][] | null}} Built
 * half axes of two ellipses, their directions in degrees; of a transfer by lines the angles between these, of others
 * the steps to the point in l, r, L, R
 * @typedef {{motion: number, theta: number[], demo: number, own: (number | null)[], seen: string,
 * recovered: (number | null)[], bones: (number | null)[] | null, E: number | null, probe: boolean, method: number,
 * map: number}} RecordedPass demo, method, map: their indices; seen: 1 for a point seen in L, in R; "" for all
 * @typedef {{condition: {name: string, value: string, level: string} | null, constructed: Record<string, Built | null>,
 * state: string, title: string, sentence: string, doubt: string, word: string, truth: string}} RecordedWords
 * constructed: by points; word: of the glossary
 * @typedef {RecordedPass & RecordedWords} RecordedMoment
 * @typedef {{transferTitle: string, servoTitle: string, crosses: boolean, rectified: boolean, lab: {transfer:
 * string, servo: string, noisePx: number, missing: number, seed: number, points: number}, lacks: string[]}} Method
 * crosses: whether it crosses epipolar lines; lab: with what the lab goes on; lacks: what the lab has not
 * @typedef {{says?: string, bars?: string, E_true?: number | null, size?: [number, number], minimum?: number[],
 * level?: number[], unknown?: number[]}} RecordedMap says: instead of a map; bars: HTML, for other than two joints;
 * E_true: px², in the demonstrator's posture
 * @typedef {{chosen: number | null, snapshots: RecordedMoment[], methods: Method[], maps: RecordedMap[],
 * demonstrators: {theta: number[], images: (number | null)[], seen: string}[]}} Run
 * @import {Line} from "../engine/affine.js" @import {Scene} from "./view.js" @import {Construction} from "./images.js" @import {Ground} from "./map.js" */

const PX = 100, RAD = 1e6, SHARE = 1000; // units of the recording in a px, a rad and the logarithm of E
/** Pairs of the views l, r, L, R, and twelve lines of a point, in the library's order. */
const PAIRS = [[0, 2], [1, 2], [0, 3], [1, 3], [0, 1], [2, 3]];
const LINE_VIEWS = [...PAIRS.map(([from, into]) => ({into, from})), ...PAIRS.map(([into, from]) => ({into, from}))];

/** @param {(number | null)[]} values */
const pixels = values => Float64Array.from(values, v => v === null ? NaN : v / PX);
/** @param {Float64Array} flat x, y of each */
const places = flat => Array.from({length: flat.length / 2}, (_, i) => [flat[2 * i], flat[2 * i + 1]]);
/** @param {number[]} values */
const angles = values => values.map(v => v / RAD);
/** @param {string} text @param {number} count */
const flags = (text, count) => Uint8Array.from({length: count}, (_, k) => +(text === "" || text[k] === "1"));

export class Recorded {
  /** @param {Run} run @param {Scene} scene */
  constructor(run, scene) {
    this.run = run;
    this.scene = scene;
    const demonstrators = run.demonstrators.map(({theta, images, seen}) =>
      ({theta: angles(theta), images: pixels(images), seen: flags(seen, images.length / 2)}));
    this.snapshots = run.snapshots.map(one => {
      const {theta: thetaDemo, images: demo, seen: demoSeen} = demonstrators[one.demo], own = pixels(one.own);
      const views = {demo, demoSeen, own, ownSeen: flags(one.seen, own.length / 2)};
      const seenByAll = (/** @type {number} */ i) =>
        [2 * i, 2 * i + 1].every(at => demoSeen[at] && views.ownSeen[at]);
      const usable = Array.from({length: own.length / 4}, (_, i) => i).filter(seenByAll);
      const bones = one.bones && pixels(one.bones), half = (bones?.length ?? 0) / 2;
      return {
        motion: one.motion, probe: one.probe, E: one.E ?? NaN, theta: angles(one.theta), thetaDemo, views, usable,
        fitted: null, recovered: pixels(one.recovered),
        bones: bones && [places(bones.subarray(0, half)), places(bones.subarray(half))],
      };
    });
    this.maps = run.maps.map(map => this.#ground(map));
  }

  /** The epipolar lines of a point, if the transfer crosses them.
   * @param {number} k @param {number} point @returns {Line[]} */
  lines(k, point) {
    const {views: {demo, own}, usable} = this.snapshots[k], method = this.run.methods[this.run.snapshots[k].method];
    if (!method.crosses || !usable.includes(point) || usable.length < MIN_POINTS) return [];
    if (method.rectified) {
      const lines = this.run.snapshots[k].constructed[point]?.lines ?? [];
      return lines.map(([a, b, c], n) => ({...LINE_VIEWS[n], a, b, c}));
    }
    const at = (/** @type {Float64Array} */ of) => of.subarray(4 * point, 4 * point + 4);
    return new EpipolarGeometry(select(demo, usable), select(own, usable)).lines(at(demo), at(own));
  }

  /** @param {number} k @param {number} point @returns {Construction | null} */
  construction(k, point) {
    const built = this.run.snapshots[k].constructed[point], {recovered} = this.snapshots[k];
    if (!built) return null;
    const axes = pixels(built.axes);
    const ellipses = [0, 1].map(side => ({
      x: recovered[4 * point + 2 * side], y: recovered[4 * point + 2 * side + 1],
      long: axes[2 * side], short: axes[2 * side + 1], turn: built.turn[side],
    }));
    return {ellipses, steps: built.steps?.map(stops => places(pixels(stops))) ?? null};
  }

  /** How a point is found, in a sentence. @param {number} k @param {number} point */
  how(k, point) {
    const built = this.run.snapshots[k].constructed[point];
    if (!built) return this.snapshots[k].usable.includes(point) ? "" : `Point ${point} is not seen in all four images.`;
    const [left, right] = built.angle ?? [];
    const found = built.angle ? `Point ${point}: lines cross at ${left}°${left === right ? "" : `, ${right}°`}.`
      : `Point ${point}: carried over by steps.`;
    return `${found} With 1 px of noise 95 % fall in the ellipse.`;
  }

  /** A map of E as map.js draws it; null where there is none. @param {RecordedMap} map @returns {Ground | null} */
  #ground({size, level, unknown, minimum}) {
    if (!size || !level || !unknown || !minimum) return null;
    const {lower, upper} = this.scene, count = level.length, E = new Float64Array(count);
    let sum = 0;
    for (let g = 0; g < count; g++) E[g] = Math.exp((sum += level[g]) / SHARE);
    for (const g of unknown) E[g] = NaN;
    const axes = size.map((steps, k) =>
      Float64Array.from({length: steps}, (_, i) => lower[k] + (upper[k] - lower[k]) * i / (steps - 1)));
    const posture = (/** @type {number} */ g) => [axes[0][Math.floor(g / size[1])], axes[1][g % size[1]]];
    return {axes, count, E, minimum: {theta: angles(minimum), E: Math.min(...E.filter(Number.isFinite))}, posture};
  }
}
