/**
 * The map of E over the learner's two joints, with the ways that were gone on it.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").Race} Race
 */
import {EnergyMap} from "../../view/map.js";
import {add, px} from "../../view/svg.js";

const DEGREE = Math.PI / 180;
const ROLES = /** @type {Record<string, [string, string]>} */ ({ // of servos: how their way is drawn, and its name
  "trust-region": ["own", "trust region"], broyden: ["opponent", "Broyden"], "gradient-retuned": ["slow", "gradient law"], gradient: ["slow", "the paper’s law"],
});

/** @type {import("../stage.js").FigureKind} */
export const landscapeKind = {
  layers: ["relief", "smallest", "demonstrator", "paths", "others", "apart", "now"],
  title: "Map of E for every pose, in px²",
  unit: "rad",
  aspect: 1.62,
  create: (box, stage) => new LessonMap(box, stage),
};

class LessonMap {
  /** @param {HTMLElement} box @param {Stage} stage */
  constructor(box, stage) {
    this.holder = box.appendChild(document.createElement("div"));
    this.holder.className = "lesson-map";
    this.holder.appendChild(document.createElement("canvas"));
    const over = add(this.holder, "svg", {class: "vi", role: "img"});
    this.map = new EnergyMap(this.holder);
    this.ways = add(over, "g");
    this.over = over;
    /** @type {unknown} */
    this.shown = null;
    this.stage = stage;
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const {scene, moment} = stage, landscape = stage.landscape(), {map} = this, hasRelief = layers.has("relief");
    const ground = [landscape, moment.views.demo, this.holder.clientWidth, this.holder.clientHeight, document.documentElement.dataset.scheme].map(each => each);
    if (!this.shown || ground.some((each, k) => each !== /** @type {unknown[]} */ (this.shown)[k])) {
      map.ground(landscape, {lower: scene.lower, upper: scene.upper, joints: scene.names});
      this.shown = ground;
    }
    this.holder.classList.toggle("blank", !hasRelief);
    const minimum = layers.has("smallest") ? landscape.minimum?.theta ?? null : null;
    const isTrueShown = layers.has("demonstrator") && !stage.truthHidden;
    const path = layers.has("paths") ? stage.motions : [], servos = layers.has("others") ? stage.step.race ?? Object.keys(stage.records.races ?? {}) : [];
    let html = "";
    for (const servo of servos) {
      const race = stage.race(servo);
      if (race) html += this.#way(race.postures.slice(0, stage.played(race.postures.length) + 1), race.probes, ...ROLES[servo] ?? ["slow", servo]);
    }
    if (path.length > 1) html += this.#way(path.map(({theta}) => theta), path.map(({probe}) => probe), "you", "you");
    if (minimum) {
      const [x, y] = map.place(minimum);
      html += `<path class="vi-cross" d="M${px(x - 7)} ${px(y)}h14m-7-7v14"/>`;
    }
    if (isTrueShown) {
      const [x, y] = map.place(moment.thetaDemo);
      html += `<path class="vi-seen" d="M${px(x - 6.5)} ${px(y)}l6.5-6.5 6.5 6.5-6.5 6.5z"/><text class="vi-of-demo vi-halo vi-b" x="${px(x + 11)}" y="${px(y - 8)}">demonstrator</text>`;
    }
    if (layers.has("now")) {
      const [x, y] = map.place(moment.theta);
      html += `<circle class="vi-now" cx="${px(x)}" cy="${px(y)}" r="7"/>`;
    }
    this.ways.innerHTML = html;
    const best = landscape.minimum;
    this.over.setAttribute("aria-label", `Map of E over ${scene.names.join(" and ")}${minimum && best ? `; E is smallest, ${best.E.toFixed(2)} px², at ${best.theta.map(v => `${Math.round(v / DEGREE)}°`).join(" and ")}` : ""}`);
  }

  /** @param {number[][]} postures @param {ArrayLike<boolean>} probes @param {string} role @param {string} name */
  #way(postures, probes, role, name) {
    const at = postures.map(theta => this.map.place(theta)), d = `M${at.map(p => p.map(px).join(" ")).join("L")}`, [x, y] = at[at.length - 1];
    const marks = at.length > 60 ? "" : at.slice(1).map(([a, b], k) => probes[k + 1] ? `<circle class="vi-way-probe vi-way-${role}" cx="${px(a)}" cy="${px(b)}" r="3"/>`
      : `<path class="vi-way-dot vi-way-${role}" d="M${px(a)} ${px(b)}h0"/>`).join("");
    const isLeft = x > this.map.width * .7;
    return `<path class="vi-line-own vi-case" d="${d}"/><path class="vi-way vi-way-${role}" d="${d}"/>${marks}
<text class="vi-way-name vi-way-${role} vi-halo vi-b${isLeft ? " vi-end" : ""}" x="${px(x + (isLeft ? -10 : 10))}" y="${px(y + 4)}">${name}</text>`;
  }

  /** @param {Stage} _ @param {import("../stage.js").Mark} mark @returns {[number, number]} */
  place(_, mark) {
    const [x, y] = this.map.place(mark);
    return [x * this.map.unit, y * this.map.unit];
  }

  /** @param {Stage} _ @param {[number, number]} at @returns {import("../stage.js").Mark} */
  unplace(_, [x, y]) {
    return /** @type {import("../stage.js").Mark} */ (this.map.posture(x / this.map.unit, y / this.map.unit));
  }
}
