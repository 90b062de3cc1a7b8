/** One of the four images, large: the arm in it, and over it the layers that the step asks for.
 * @import {Stage, FigureKind} from "../stage.js" @import {Line} from "../rays.js" @import {Moment} from "../../engine/session.js" @import {Layer} from "./view-layers.js" @import {Rectangle} from "./drawing.js" */
import {Outlines} from "../../view/images.js";
import {around} from "./drawing.js";
import {Plane} from "./plane.js";
import {TOUR_LAYERS_ABOVE, TOUR_LAYERS_BELOW, TOUR_LEGEND} from "./tour-layers.js";
import {arm, LIMITS_LAYERS, OWN_LAYERS, OWN_LEGEND} from "./view-layers.js";

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

class View extends Plane {
  /** @param {"l" | "r" | "L" | "R"} name @param {HTMLElement} box @param {Stage} stage */
  constructor(name, box, stage) {
    super(box);
    this.name = name;
    this.k = VIEWS.indexOf(name);
    this.outlines = new Outlines(stage.page.hulls);
    this.fitted = "";
    this.span = /** @type {Rectangle} */ ([0, 0, 1, 1]); // px that it shows at least
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const {moment, world} = stage, {k, outlines, name, width, height} = this, side = /** @type {0 | 1} */ (k & 1);
    this.#fit(stage, layers);
    const {views} = moment, isDemo = k < 2, images = isDemo ? views.demo : views.own;
    const seen = isDemo ? views.demoSeen : views.ownSeen, at = (/** @type {ArrayLike<number>} */ p) => this.at(p);
    const shown = Array.from({length: images.length / 4}, (_, i) => i).filter(i => seen[2 * i + side]);
    const frame = {
      name, k, side, isDemo, images, seen, width, height, scale: this.window.scale, at, shown, layers, outlines,
      of: (/** @type {ArrayLike<number>} */ of, /** @type {number} */ i) =>
        at([of[4 * i + 2 * side], of[4 * i + 2 * side + 1]]),
      ends: (/** @type {Line} */ line) => this.ends(line),
    };
    const own = isDemo ? outlines.of(world, "demonstrator", moment.thetaDemo, "demo")
      : outlines.of(world, "learner", moment.theta, "own");
    const names = Object.keys(VIEW_LAYERS).filter(layer => layers.has(layer));
    const behind = layers.has("ghost") ? VIEW_LAYERS.ghost(frame, stage) : "";
    const over = names.filter(layer => layer !== "ghost").map(layer => VIEW_LAYERS[layer](frame, stage)).join("");
    const html = `${behind}<g class="${isDemo ? "vi-demo" : ""}">${arm(own[side], frame, "vi-hull", "vi-bone")}</g>${over}`;
    this.box.classList.toggle("framed", layers.has("framed"));
    const whose = isDemo ? "the demonstrator" : "the learner’s own arm", eye = side ? "right" : "left";
    this.show(html, `Image ${name}: ${whose}, seen by the ${eye} eye${names.length ? `; it shows ${names.join(", ")}` : ""}`);
  }

  resize() {
    this.measure();
    this.fitted = "";
  }

  /** The window holds the arm where it begins, where it should go and wherever it has been.
   * @param {Stage} stage @param {Set<string>} layers */
  #fit(stage, layers) {
    const {world, step, moment} = stage, {k} = this, side = k & 1, who = k < 2 ? "demonstrator" : "learner";
    const key = `${step.id} ${stage.seed} ${world.scene.cameras[k].centre} ${layers.has("recovered points")}`;
    const isNew = key !== this.fitted, [left, top, right, bottom] = this.span;
    const held = /** @type {ArrayLike<number>[]} */ (isNew ? [] : [[left, top], [right, bottom]]);
    const holdArm = (/** @type {number[]} */ theta, /** @type {string} */ name) => {
      const {hulls, bones} = this.outlines.of(world, who, theta, name)[side];
      held.push(...hulls.flat(), ...bones);
    };
    const holdRecovered = (/** @type {Moment} */ there) => {
      const found = stage.recovered(there);
      for (const i of there.usable) held.push(found.subarray(4 * i + 2 * side, 4 * i + 2 * side + 2));
    };
    holdArm(k < 2 ? moment.thetaDemo : moment.theta, k < 2 ? "demo" : "own");
    if (isNew && k > 1) for (const theta of [stage.state.start, moment.thetaDemo,
      ...stage.motions.map(motion => motion.theta)]) holdArm(theta, "fit");
    if (layers.has("guessed") && k > 1) holdArm(stage.guessed, "guess");
    if (k > 1 && layers.has("recovered points")) holdRecovered(moment);
    if (isNew && k > 1) holdRecovered(stage.session.observe(stage.state.start));
    const span = around(held);
    if (!isNew && this.window.scale && span.every((v, i) => Math.abs(v - this.span[i]) < .5)) return;
    this.fitted = key;
    this.span = span;
    this.aim(span, {margin: [MARGIN, MARGIN, MARGIN, MARGIN], glide: false});
  }
}
