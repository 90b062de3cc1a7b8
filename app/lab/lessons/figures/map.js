/**
 * The map of E over the learner's two joints, with the ways that were gone on it.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").Race} Race
 */
import {EnergyMap} from "../../view/map.js";
import {add, px} from "../../view/svg.js";
import {Names} from "./plane.js";

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
    const names = this.#names();
    /** @type {[number[][], ArrayLike<boolean>, string, string][]} */
    const ways = servos.flatMap(servo => {
      const race = stage.race(servo), [role, name] = ROLES[servo] ?? ["slow", servo];
      if (!race) return [];
      const last = stage.last(race); // what a servo looks at after it has reached the goal is not shown
      return [[race.postures.slice(0, stage.played(last + 1) + 1), race.probes, role, name]];
    });
    if (path.length > 1) ways.push([path.map(({theta}) => theta), path.map(({probe}) => probe), "you", "you"]);
    for (const [postures, probes, role] of ways) html += this.#way(postures, probes, role, names);
    if (minimum) {
      const [x, y] = map.place(minimum);
      names.keep([x, y], 9);
      html += `<path class="vi-cross" d="M${px(x - 7)} ${px(y)}h14m-7-7v14"/>`;
    }
    if (isTrueShown) {
      const [x, y] = map.place(moment.thetaDemo);
      html += `<path class="vi-seen" d="M${px(x - 6.5)} ${px(y)}l6.5-6.5 6.5 6.5-6.5 6.5z"/>`;
      names.keep([x, y], 8);
      names.put("demonstrator", [x, y], "vi-of-demo", {away: 12, first: [1, -1]});
    }
    if (layers.has("now")) {
      const [x, y] = map.place(moment.theta);
      html += `<circle class="vi-now" cx="${px(x)}" cy="${px(y)}" r="7"/>`;
      names.keep([x, y], 9);
    }
    for (const [postures, , role, name] of ways) names.put(name, map.place(postures[postures.length - 1]), `vi-way-name vi-way-${role}`, {away: 9});
    this.ways.innerHTML = html + names.html;
    const best = landscape.minimum;
    this.over.setAttribute("aria-label", `Map of E over ${scene.names.join(" and ")}${minimum && best ? `; E is smallest, ${best.E.toFixed(2)} px², at ${best.theta.map(v => `${Math.round(v / DEGREE)}°`).join(" and ")}` : ""}`);
  }

  /** Names that keep clear of the contours' numbers and of the axes. */
  #names() {
    const {map} = this, names = new Names(map.width, map.height), corners = [map.place(map.range.lower), map.place(map.range.upper)];
    names.keepBox([0, corners[0][1], map.width, map.height]);
    names.keepBox([0, 0, corners[0][0], map.height]);
    for (const text of map.standing.querySelectorAll("text")) {
      const [x, y] = ["x", "y"].map(name => Number(text.getAttribute(name)));
      names.keepBox([x - 14, y - 13, x + 14, y + 4]);
    }
    return names;
  }

  /** @param {number[][]} postures @param {ArrayLike<boolean>} probes @param {string} role @param {Names} names */
  #way(postures, probes, role, names) {
    const at = postures.map(theta => this.map.place(theta)), d = `M${at.map(p => p.map(px).join(" ")).join("L")}`;
    at.forEach((p, k) => { if (k) names.keepLine(at[k - 1], p, 3); else names.keep(p, 4); });
    const marks = at.length > 60 ? "" : at.slice(1).map(([a, b], k) => probes[k + 1] ? `<circle class="vi-way-probe vi-way-${role}" cx="${px(a)}" cy="${px(b)}" r="3"/>`
      : `<path class="vi-way-dot vi-way-${role}" d="M${px(a)} ${px(b)}h0"/>`).join("");
    return `<path class="vi-line-own vi-case" d="${d}"/><path class="vi-way vi-way-${role}" d="${d}"/>${marks}`;
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
