/** One of the four images, large: the arm in it, and over it the layers that the step asks for.
 * @import {Stage, FigureKind} from "../stage.js" @import {Layer} from "./view-layers.js" */
import {Outlines} from "../../view/images.js";
import {add, drawingSize, set} from "../../view/svg.js";
import {LIMITS_LAYERS} from "./limits-layers.js";
import {TOUR_LAYERS_ABOVE, TOUR_LAYERS_BELOW, TOUR_LEGEND} from "./tour-layers.js";
import {arm, OWN_LAYERS, OWN_LEGEND} from "./view-layers.js";

const VIEWS = "lrLR", MARGIN = 14; // drawing units around the arm
const CAPTIONS = {l: "left eye, demonstrator", r: "right eye, demonstrator", L: "left eye, own arm",
  R: "right eye, own arm"};

/** Every owner adds layers here. @type {Record<string, Layer>} */
export const VIEW_LAYERS = {...TOUR_LAYERS_BELOW, ...OWN_LAYERS, ...LIMITS_LAYERS, ...TOUR_LAYERS_ABOVE};

/** What their marks mean. @type {Record<string, string>} */
const LEGEND = {...OWN_LEGEND, ...TOUR_LEGEND};

/** @param {"l" | "r" | "L" | "R"} name @returns {FigureKind} */
export const viewKind = name => ({
  layers: Object.keys(VIEW_LAYERS),
  title: `**${name}** ${CAPTIONS[name]}`,
  aspect: .68,
  legend: LEGEND,
  create: (box, stage) => new View(name, box, stage),
});

class View {
  /** @param {"l" | "r" | "L" | "R"} name @param {HTMLElement} box @param {Stage} stage */
  constructor(name, box, stage) {
    this.name = name;
    this.k = VIEWS.indexOf(name);
    this.box = box;
    this.outlines = new Outlines(stage.page.hulls);
    this.svg = add(box, "svg", {class: "vi", role: "img"});
    this.window = {x: 0, y: 0, scale: 1, width: 1, height: 1, unit: 1};
    this.last = "";
    this.fitted = "";
    /** px that it shows at least: left, top, right, bottom */
    this.span = [0, 0, 1, 1];
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const {moment, world} = stage, {k, outlines} = this, side = /** @type {0 | 1} */ (k & 1), isDemo = k < 2;
    this.#fit(stage, layers);
    const {x, y, scale, width, height} = this.window;
    const at = (/** @type {ArrayLike<number>} */ p) => /** @type {[number, number]} */ ([(p[0] - x) * scale,
      (p[1] - y) * scale]);
    const images = isDemo ? moment.views.demo : moment.views.own, seen = isDemo ? moment.views.demoSeen
      : moment.views.ownSeen;
    const shown = Array.from({length: images.length / 4}, (_, i) => i).filter(i => seen[2 * i + side]);
    const frame = {
      name: this.name, k, side, isDemo, images, seen, width, height, scale, at, shown, layers, outlines,
      of: (/** @type {ArrayLike<number>} */ of, /** @type {number} */ i) =>
        at([of[4 * i + 2 * side], of[4 * i + 2 * side + 1]]),
    };
    const own = isDemo ? outlines.of(world, "demonstrator", moment.thetaDemo, "demo")
      : outlines.of(world, "learner", moment.theta, "own");
    const names = Object.keys(VIEW_LAYERS).filter(layer => layers.has(layer)), isBehind = layers.has("ghost");
    const behind = isBehind ? VIEW_LAYERS.ghost(frame, stage) : "";
    const over = names.filter(layer => layer !== "ghost").map(layer => VIEW_LAYERS[layer](frame, stage)).join("");
    const html = `${behind}<g class="${isDemo ? "vi-demo" : ""}">${arm(own[side], frame, "vi-hull", "vi-bone")}</g>${over}`;
    this.box.classList.toggle("framed", layers.has("framed"));
    if (html !== this.last) this.svg.innerHTML = this.last = html;
    const whose = isDemo ? "the demonstrator" : "the learner’s own arm";
    set(this.svg,
      {"aria-label": `Image ${this.name}: ${whose}, seen by the ${side ? "right" : "left"} eye${names.length ? `; it shows ${names.join(", ")}` : ""}`});
  }

  /** @param {Stage} _ @param {import("../stage.js").Mark} mark @returns {[number, number]} */
  place(_, [a, b]) {
    const {x, y, scale, unit} = this.window;
    return [(a - x) * scale * unit, (b - y) * scale * unit];
  }

  /** @param {Stage} _ @param {[number, number]} at @returns {import("../stage.js").Mark} */
  unplace(_, [a, b]) {
    const {x, y, scale, unit} = this.window;
    return [a / unit / scale + x, b / unit / scale + y];
  }

  resize() {
    this.fitted = "";
  }

  /** The window holds the arm where it begins, where it should go and wherever it has been.
   * @param {Stage} stage @param {Set<string>} layers */
  #fit(stage, layers) {
    const {world, step, moment} = stage, {k} = this, side = k & 1, {unit, width, height} = drawingSize(this.box);
    const key = `${step.id} ${stage.seed} ${world.scene.cameras[k].centre} ${layers.has("recovered points")} ${unit} ${width} ${height}`;
    const who = k < 2 ? "demonstrator" : "learner", isNew = key !== this.fitted, span = isNew
      ? [Infinity, Infinity, -Infinity, -Infinity] : [...this.span];
    const hold = (/** @type {ArrayLike<number>} */ p) => {
      span[0] = Math.min(span[0], p[0]);
      span[1] = Math.min(span[1], p[1]);
      span[2] = Math.max(span[2], p[0]);
      span[3] = Math.max(span[3], p[1]);
    };
    const holdArm = (/** @type {number[]} */ theta, /** @type {string} */ name) => {
      const {hulls, bones} = this.outlines.of(world, who, theta, name)[side];
      hulls.flat().forEach(hold);
      bones.forEach(hold);
    };
    const holdRecovered = (/** @type {import("../../engine/session.js").Moment} */ there) => {
      const found = stage.recovered(there);
      for (const i of there.usable) hold([found[4 * i + 2 * side], found[4 * i + 2 * side + 1]]);
    };
    holdArm(k < 2 ? moment.thetaDemo : moment.theta, k < 2 ? "demo" : "own");
    if (isNew && k > 1) for (const theta of [stage.state.start, moment.thetaDemo,
      ...stage.motions.map(motion => motion.theta)]) holdArm(theta, "fit");
    if (layers.has("guessed") && k > 1) holdArm(stage.guessed, "guess");
    if (k > 1 && layers.has("recovered points")) holdRecovered(moment);
    if (isNew && k > 1) holdRecovered(stage.session.observe(stage.state.start));
    if (!isNew && span.every((v, i) => Math.abs(v - this.span[i]) < .5)) return;
    this.fitted = key;
    this.span = span;
    const scale = Math.min((width - 2 * MARGIN) / Math.max(span[2] - span[0], 1),
      (height - 2 * MARGIN) / Math.max(span[3] - span[1], 1));
    this.window = {x: (span[0] + span[2]) / 2 - width / scale / 2, y: (span[1] + span[3]) / 2 - height / scale / 2,
      scale, width, height, unit};
    set(this.svg, {viewBox: `0 0 ${width} ${height}`});
  }
}
