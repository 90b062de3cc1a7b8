/** The room from above, with the demonstrator moved about in it, and E there beside E of other shapes.
 * @import {Stage, FigureKind} from "../stage.js" */
import {outermost, silhouettes} from "../../view/images.js";
import {energyText, px} from "../../view/svg.js";
import {once} from "../../view/once.js";
import {movedPlaces} from "../places.js";
import {Chart} from "./chart.js";
import {Names} from "./names.js";
import {around} from "./drawing.js";
import {Plane} from "./plane.js";

const GRID_M = 0.5, PEDESTAL_M = 0.15; // between lines; half its side
const HEAD_M = 0.05; // half a head's depth in the drawing
const SHAPES = 21; // learner's poses between the demonstrator's and its start
const SHAPE_END = 1, PLACES_FROM = 1.3, PLACES_TO = 2.2; // on the axis: where shapes end, and places are
const MIN_E = 0.3;

/** From above: to the left is to the left of the eyes, up is away from them. @param {ArrayLike<number>} p m */
const above = p => [-p[1], -p[0]];

/** E in all places of a stage: it is asked for in every frame. @param {Stage} stage */
const placesOf = stage =>
  once(stage, "places", () => movedPlaces(stage), `${stage.moment.theta} ${stage.moment.thetaDemo}`);

/** @type {FigureKind} */
export const roomFromAbove = {
  layers: ["arms", "eyes", "places", "E there"],
  title: "**The room from above**",
  aspect: 0.85,
  create: (box, stage) => new Room(box, stage),
};

class Room extends Plane {
  /** @param {HTMLElement} box @param {Stage} stage */
  constructor(box, stage) {
    super(box);
    this.hulls = outermost(stage.page.hulls);
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const {arms, scene} = stage.world, {moment} = stage;
    const names = new Names([0, 0, this.width, this.height]);
    const places = placesOf(stage), count = layers.has("places") ? Math.ceil(stage.reveal * places.length) : 0;
    const outline = (/** @type {"demonstrator" | "learner"} */ who, /** @type {number[]} */ theta) =>
      silhouettes(this.hulls, arms[who].linkFrames(theta), above);
    const demonstrator = outline("demonstrator", moment.thetaDemo), learner = outline("learner", moment.theta);
    const moved = places.map(({x, y}) => demonstrator.map(points => points.map(([u, v]) => [u - y, v - x])));
    const head = above(scene.cameras[0].centre.map((v, i) => (v + scene.cameras[1].centre[i]) / 2));
    const bases = {demonstrator: above([arms.demonstrator.T_world_base[3], arms.demonstrator.T_world_base[7]]),
      learner: above([arms.learner.T_world_base[3], arms.learner.T_world_base[7]])};
    this.aim(around([...demonstrator.flat(), ...learner.flat(), ...moved.flat(2), [head[0], head[1] + .3]]),
      {margin: [44, 26, 20, 30], glide: false});
    let html = `<path class="draw-floor" d="${this.#grid()}"/>`;
    const body = (/** @type {number[][][]} */ hulls, /** @type {number[]} */ base, /** @type {string} */ kind) => {
      const square = [[-1, -1], [1, -1], [1, 1], [-1, 1]]
        .map(([a, b]) => [base[0] + a * PEDESTAL_M, base[1] + b * PEDESTAL_M]);
      html += `<g class="${kind}"><path class="draw-pedestal" d="${this.path(square, true)}"/>` +
        `<path class="vi-hull" d="${hulls.map(points => this.path(points, true)).join("")}"/></g>`;
      hulls.forEach(points => {
        const [l, t, r, b] = around(points.map(p => this.at(p)));
        names.keepBox([l, t, r, b]);
      });
      names.keepBox(around(square.map(p => this.at(p))));
      return base;
    };
    const sight = (/** @type {number[]} */ to) => {
      html += `<path class="draw-gaze" d="${this.path([head, to])}"/>`;
    };
    if (layers.has("eyes")) {
      sight(bases.demonstrator);
      sight(bases.learner);
      places.slice(0, count).forEach(({x, y}) => sight([bases.demonstrator[0] - y, bases.demonstrator[1] - x]));
    }
    const said = /** @type {[number[], string, string][]} */ ([]);
    moved.slice(0, count).forEach((hulls, k) => {
      const {x, y, E} = places[k];
      const base = body(hulls, [bases.demonstrator[0] - y, bases.demonstrator[1] - x], "vi-demo draw-moved");
      if (layers.has("E there")) said.push([base, energyText(E), "draw-name-E"]);
    });
    if (layers.has("arms")) {
      body(demonstrator, bases.demonstrator, "vi-demo");
      body(learner, bases.learner, "");
    }
    if (layers.has("eyes")) {
      const centres = [...scene.cameras.slice(0, 2), ...scene.cameras.slice(2)].map(({centre}) => above(centre));
      const half = Math.max(...centres.map(p => Math.hypot(p[0] - head[0], p[1] - head[1])));
      const corners = [[-half, -HEAD_M], [half, -HEAD_M], [half, HEAD_M], [-half, HEAD_M]]
        .map(([a, b]) => [head[0] + a, head[1] + b]);
      html += `<path class="draw-head" d="${this.path(corners, true)}"/>`;
      names.keepBox(around(corners.map(p => this.at(p))));
      names.put("two eyes", this.at([head[0], head[1] + HEAD_M]), "vi-2nd", {away: 7, first: [0, 1]});
    }
    const side = PEDESTAL_M * this.window.scale;
    if (layers.has("E there") && count) said.push([bases.demonstrator, energyText(moment.E), "draw-name-E"]);
    for (const [base, text, kind] of said) names.put(text, this.at(base), kind,
      {size: this.width > 420 ? 15 : 13, away: side + 3, first: [-1, 0]});
    if (layers.has("arms")) names.put("learner", this.at(bases.learner), "vi-of-own", {away: side + 4, first: [0, 1]});
    if (layers.has("arms")) names.put("demonstrator", this.at(bases.demonstrator), "vi-of-demo",
      {away: side + 4, first: [0, 1]});
    html += this.#scale();
    const where = places.slice(0, count)
      .map(({x, y, E}) => `${x} m farther and ${y} m sideways: ${energyText(E)}`).join("; ");
    this.show(html + names.html,
      `The room from above: two eyes, the demonstrator and the learner. E is ${energyText(moment.E)} ` +
      `px².${count ? ` Carried, ${where}.` : ""}`);
  }

  #grid() {
    const [left, top] = this.unplace(null, [0, 0]);
    const [right, bottom] = this.unplace(null, [this.width * this.unit, this.height * this.unit]);
    let d = "";
    for (let v = Math.ceil(left / GRID_M); v * GRID_M < right; v++) d += this.path([[v * GRID_M, top],
      [v * GRID_M, bottom]]);
    for (let v = Math.ceil(top / GRID_M); v * GRID_M < bottom; v++) d += this.path([[left, v * GRID_M],
      [right, v * GRID_M]]);
    return d;
  }

  /** Half a metre, in a corner. */
  #scale() {
    const long = GRID_M * this.window.scale, y = this.height - 12;
    return `<path class="draw-scale" d="M12 ${px(y)}h${px(long)}"/>` +
      `<text class="vi-2nd" style="font-size:12px" x="${px(18 + long)}" y="${px(y + 4)}">0.5 m</text>`;
  }
}

/** E of other shapes beside E in other places, on one logarithmic axis. @type {FigureKind} */
export const energyAxis = {
  layers: ["another shape", "another place"],
  title: "**E** by shape and by place",
  aspect: 0.85,
  create: box => {
    const chart = new Chart(box);
    /** @type {{stage: Stage | null, points: number[][]}} */
    let shapes = {stage: null, points: []};
    return {
      resize: () => chart.resize(),
      draw: (stage, layers) => {
        const {moment, session} = stage;
        if (shapes.stage !== stage) shapes = {stage, points: Array.from({length: SHAPES}, (_, k) => {
          const share = k / (SHAPES - 1) * SHAPE_END;
          return [share, Math.max(MIN_E,
            session.observe(moment.thetaDemo.map((v, j) => v + share * (moment.theta[j] - v))).E)];
        })};
        const places = placesOf(stage), count = Math.ceil(stage.reveal * places.length);
        const dots = [{E: moment.E}, ...places].slice(0, layers.has("another place") ? 1 + count : 0)
          .map(({E}, k) => [PLACES_FROM + k / places.length * (PLACES_TO - PLACES_FROM), E]);
        const elsewhere = places.slice(0, count).map(({E}) => energyText(E)).join(", ");
        const there = count ? ` In other places it is ${elsewhere}.` : "";
        const most = Math.max(...shapes.points.map(p => p[1]), ...places.map(({E}) => E));
        chart.draw({
          x: [-.08, PLACES_TO + .15], y: [MIN_E, most * 2], log: true, yName: "E, px²",
          xTicks: [[0, "same pose"], [SHAPE_END, "different"]],
        }, [
          {points: layers.has("another shape") ? shapes.points : [], role: "learner", name: "another shape",
            named: Math.round(.45 * SHAPES)},
          {points: dots, role: "demonstrator", line: false, name: count ? "another place" : "",
            named: Math.min(2, dots.length - 1)},
        ], `E grows from ${energyText(shapes.points[0][1])} to ${energyText(moment.E)} px² in another pose.${there}`);
      },
    };
  },
};
