/** Teaching by showing as it goes: three gains side by side, a turned camera, and how far the dots are from the goal.
 * @import {Stage, FigureKind} from "../stage.js" @import {Run} from "../teach_by_showing.js" */
import {Outlines} from "../../view/images.js";
import {DEGREE, px} from "../../view/svg.js";
import {GAIN_STEPS, GAINS, gainRuns, THERE_PX, turnedPoint, turnedRuns, TURNED_STEPS} from "../measures_jacobian.js";
import {rolled, stepsTo} from "../teach_by_showing.js";
import {make} from "../dom.js";
import {charted, stepTicks} from "./chart.js";
import {Names} from "./names.js";
import {around, circles} from "./drawing.js";
import {Plane} from "./plane.js";

const ROLES = ["plain", "learner", "opponent"]; // of the three gains, and of still, old, Broyden
const REACH_PX = 12; // around paths, that the window of the turned picture holds
const INSET = 0.3, INSET_MOST = 170; // of the drawing's width; drawing units
const SWINGS = 4; // last postures of which a gain that never arrives shows the way

/** The links' outlines and the chain in L. @param {Stage} stage @param {Outlines} outlines @param {number[]} theta */
const seenInL = ({world}, outlines, theta) => outlines.of(world, "learner", theta, "in L")[0];

/** A point's path in L. @param {Run} run @param {number} point @param {number} [upTo] how many steps */
const pathOf = ({images}, point, upTo = images.length - 1) => images.slice(0, upTo + 1)
  .map(all => [all[4 * point], all[4 * point + 1]]);

/** @type {FigureKind} */
export const threeGains = {
  layers: ["start", "goal", "paths"],
  aspect: 2,
  create: (box, stage) => new Gains(box, stage),
};

class Gains {
  /** @param {HTMLElement} box @param {Stage} stage */
  constructor(box, stage) {
    this.box = box.appendChild(make("div", {class: "draw-gains"}));
    this.outlines = new Outlines(stage.page.hulls);
    this.panels = GAINS.map((gain, k) => {
      const title = make("p"), drawing = make("div", {class: "draw-gain"});
      this.box.append(make("div", {}, title, drawing));
      return {gain, k, title, plane: new Plane(drawing)};
    });
  }

  resize() { this.panels.forEach(({plane}) => plane.measure()); }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const runs = gainRuns(stage), steps = layers.has("paths") ? Math.round(stage.reveal * GAIN_STEPS) : 0;
    const goal = seenInL(stage, this.outlines, stage.state.demonstrator);
    const start = seenInL(stage, this.outlines, stage.state.start);
    const shown = runs.flatMap(run => run.postures.slice(-SWINGS)).map(theta => seenInL(stage, this.outlines, theta));
    const spans = around([goal, start, ...shown].flatMap(one => one.hulls.flat()));
    for (const {gain, k, title, plane} of this.panels) {
      const run = runs[k], arrived = stepsTo(run, THERE_PX);
      const now = Math.min(steps, Number.isFinite(arrived) ? Math.max(arrived, 1) : steps);
      const arm = seenInL(stage, this.outlines, run.postures[now]), images = run.images[now];
      const points = stage.world.body.length;
      const each = Array.from({length: points}, (_, i) => i);
      plane.aim(spans, {margin: [10, 10, 10, 10], glide: false});
      const dots = (/** @type {Float64Array} */ of, /** @type {number} */ r) => each
        .map(i => circles([plane.at([of[4 * i], of[4 * i + 1]])], r)).join("");
      const isDone = now === arrived && steps >= arrived;
      let html = `<g class="draw-dim">` +
        `<path class="vi-hull" d="${arm.hulls.map(points => plane.path(points, true)).join("")}"/></g>` +
        `<path class="vi-bone" d="${plane.path(arm.bones)}"/>`;
      if (layers.has("goal")) html += `<path class="draw-goal" d="${dots(run.goal, 4.6)}"/>`;
      const since = Number.isFinite(arrived) ? 0 : -SWINGS;
      const ways = each.map(i => plane.path(pathOf(run, i, now).slice(since)));
      if (layers.has("paths") && now) html += `<path class="draw-trail draw-of-${ROLES[k]}" d="${ways.join("")}"/>`;
      html += `<path class="draw-own-dot" d="${dots(images, 3.6)}"/>`;
      const said = !layers.has("paths") || !steps ? "" : isDone ? `${now} steps`
        : `step ${steps}: ${Math.round(run.errors[steps])} px`;
      plane.show(html, `Gain ${gain}: ${said || "the start, and grey circles where the dots should go"}`);
      title.innerHTML = `<b class="draw-name-${ROLES[k]}">gain ${gain}</b> ` +
        `<span class="${isDone ? "draw-done" : ""}">${said}</span>`;
    }
  }
}

/** @type {FigureKind} */
export const turnedPicture = {
  layers: ["start", "goal", "camera", "old Jacobian", "not turned", "Broyden"],
  title: "**L** left eye, turned and enlarged",
  aspect: 1,
  create: (box, stage) => new Turned(box, stage),
};

class Turned extends Plane {
  /** @param {HTMLElement} box @param {Stage} stage */
  constructor(box, stage) {
    super(box);
    this.outlines = new Outlines(stage.page.hulls);
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const roll = stage.sliders.get("roll") ?? 90, {still, old, broyden} = turnedRuns(stage);
    const point = turnedPoint(stage);
    const camera = stage.world.pairs.learner[0], turn = (/** @type {number[][]} */ points) => points.map(p => {
      const [a, b] = rolled(Float64Array.of(p[0], p[1]), roll * DEGREE, camera.principal);
      return [a, b];
    });
    const steps = Math.round(stage.reveal * TURNED_STEPS), goal = [old.goal[4 * point], old.goal[4 * point + 1]];
    const shown = /** @type {[string, string, number[][]][]} */ ([
      ["not turned", ROLES[0], turn(pathOf(still, point, steps))],
        ["old Jacobian", ROLES[1], pathOf(old, point, steps)],
      ["Broyden", ROLES[2], pathOf(broyden, point, steps)],
    ]).filter(([layer]) => layers.has(layer));
    const whole = [pathOf(old, point), pathOf(broyden, point)].flat(), start = pathOf(old, point, 0)[0];
    const [left, top, right, bottom] = around(stage.reveal > 0 ? [...whole, goal, start]
      : [goal, start, [2 * goal[0] - start[0], 2 * goal[1] - start[1]]]);
    const reach = Math.max(REACH_PX, (right - left) * .12);
    const moves = this.aim([left - reach, top - reach, right + reach, bottom + reach],
      {margin: [20, 30, 20, 20], most: 14});
    const arms = [[stage.state.demonstrator, "draw-ghost"], [stage.state.start, ""]].map(([theta, kind]) => {
      const {hulls} = seenInL(stage, this.outlines, /** @type {number[]} */ (theta));
      return {hulls: hulls.map(turn), kind};
    });
    const names = new Names([0, 0, this.width, this.height]);
    const outline = (/** @type {number[][][]} */ hulls) => hulls.map(points => this.path(points, true)).join("");
    let html = arms.map(({hulls, kind}) => kind ? `<path class="${kind}" d="${outline(hulls)}"/>`
      : `<path class="vi-hull" d="${outline(hulls)}"/>`).join("");
    for (const [, role, points] of shown) {
      const at = points.map(p => this.at(p));
      html += `<path class="draw-track draw-of-${role}" d="${this.path(points)}"/>`;
      if (role !== "plain") html +=
        `<path class="draw-dots draw-of-${role}" d="${circles(at, 2.8)}"/>`;
      names.keepLine(at, 4);
    }
    const now = this.at(shown.find(([layer]) => layer === "old Jacobian")?.[2].slice(-1)[0] ?? start);
    const ring = this.at(goal), from = this.at(start);
    names.keep(ring, 12);
    names.keep(from, 14);
    if (layers.has("goal")) html += `<path class="draw-goal" d="${circles([ring], 9)}"/>`;
    html += `<path class="vi-ring" d="${circles([from], 11)}"/><path class="draw-own-dot" d="${circles([now], 5.5)}"/>`;
    const inset = layers.has("camera") ? this.#inset(stage, arms, names, roll) : "";
    if (layers.has("goal")) names.put("goal", ring, "vi-2nd", {away: 12, first: [1, -1]});
    names.put(stage.reveal > 0 ? "start" : "the dot", from, "vi-chosen", {away: 14, first: [-1, 1]});
    for (const [layer, role, points] of shown) if (stage.reveal === 1 && layer !== "not turned") {
      const far = points.reduce((a, b) =>
        Math.hypot(b[0] - goal[0], b[1] - goal[1]) > Math.hypot(a[0] - goal[0], a[1] - goal[1])
        && layer === "Broyden" ? b : a, points[Math.min(3, points.length - 1)]);
      names.put(layer, this.at(far), `draw-name-${role}`, {away: 10});
    }
    const came = `With the old Jacobian it is ${stepsText(old)}, with Broyden’s update ${stepsText(broyden)}.`;
    this.show(html + inset + names.html,
      `Image L of a camera turned by ${Math.round(roll)}°: one dot and its goal. ${stage.reveal > 0 ? came : ""}`);
    if (moves) this.again(() => this.draw(stage, layers));
  }

  /** The whole picture, small, and how the camera is turned.
   * @param {Stage} stage @param {{hulls: number[][][], kind: string | number[]}[]} arms @param {Names} names
   * @param {number} roll degrees */
  #inset(stage, arms, names, roll) {
    const {width, height, principal: [cx, cy]} = stage.world.pairs.learner[0];
    const frame = [[0, 0], [width, 0], [width, height], [0, height]];
    const turned = frame.map(p => [...rolled(Float64Array.from(p), roll * DEGREE, [cx, cy])]), span = around(turned);
    const most = Math.min(INSET * this.width, INSET_MOST), size = [span[2] - span[0], span[3] - span[1]];
    const scale = most / Math.max(...size), [wide, high] = size.map(v => v * scale + 12);
    const places = [[8, this.height - high - 8], [this.width - wide - 8, this.height - high - 8],
      [this.width - wide - 8, 8], [8, 34]];
    const crowd = (/** @type {number[]} */ [x, y]) => names.taken
      .filter(([l, t, r, b]) => l < x + wide && r > x && t < y + high && b > y).length;
    const [x, y] = places.reduce((a, b) => crowd(b) < crowd(a) ? b : a);
    names.keepBox([x, y, x + wide, y + high]);
    const at = (/** @type {number[]} */ p) => [x + wide / 2 + (p[0] - cx) * scale, y + high / 2 + (p[1] - cy) * scale]
      .map(px).join(" ");
    const path = (/** @type {number[][]} */ points) => `M${points.map(at).join("L")}z`;
    const w = this.window, view = [[0, 0], [this.width, 0], [this.width, this.height], [0, this.height]]
      .map(([a, b]) => [a / w.scale + w.x, b / w.scale + w.y]);
    const up = [[cx, 10], [cx, -40]].map(p => [...rolled(Float64Array.from(p), roll * DEGREE, [cx, cy])]);
    const id = `inset-${Math.round(x)}-${Math.round(y)}-${Math.round(wide)}`;
    const place = `x="${px(x)}" y="${px(y)}" width="${px(wide)}" height="${px(high)}" rx="5"`;
    const bodies = arms.map(({hulls, kind}) =>
      `<path class="${kind || "vi-hull"}" d="${hulls.map(path).join("")}"/>`).join("");
    return `<clipPath id="${id}"><rect ${place}/></clipPath><g clip-path="url(#${id})">
<rect class="draw-inset" ${place}/>
<path class="draw-frame" d="${path(turned)}"/>${bodies}
<path class="draw-up" d="M${up.map(at).join("L")}"/><path class="draw-window" d="${path(view)}"/></g>
<rect class="draw-inset-rim" ${place}/>`;
  }
}

/** @param {Run} run */
const stepsText = run => {
  const found = stepsTo(run, THERE_PX);
  return Number.isFinite(found) ? `there after ${found} steps` : "never there";
};

/** How far the dots are from the goal, step by step. @type {FigureKind} */
export const dotToGoal = {
  layers: ["curves"],
  title: "Off the goal, px",
  aspect: 1.1,
  create: charted((stage, layers) => {
    const isTurned = stage.sliders.has("roll"), last = isTurned ? TURNED_STEPS : GAIN_STEPS;
    const runs = isTurned ? Object.values(turnedRuns(stage)) : gainRuns(stage);
    const titles = isTurned ? ["not turned", "old Jacobian", "Broyden"] : GAINS.map(gain => `gain ${gain}`);
    const steps = layers.has("curves") ? Math.round(stage.reveal * last) : 0;
    const curves = runs.map((run, k) => {
      const arrived = stepsTo(run, THERE_PX), isThere = stage.reveal === 1 && layers.has("curves");
      const most = run.errors.slice(0, steps + 1)
        .reduce((best, error, at, all) => error > all[best] && at < 8 ? at : best, 0);
      const named = isTurned && k === 2 ? most : isTurned ? (k ? 9 : 4) : [8, 1, 6][k];
      return {
        points: run.errors.map((error, step) => [step, error]), role: ROLES[k], shown: steps + 1, named,
        name: steps ? `${titles[k]}${isThere ? `: ${Number.isFinite(arrived) ? arrived : "never"}` : ""}` : "",
      };
    });
    const most = Math.max(...runs.flatMap(({errors}) => errors));
    return [{
      x: [0, last], y: [0, most * 1.12], xTicks: stepTicks(last), xName: "steps",
      levels: [[THERE_PX, "there: 2 px", "goal"]],
    }, curves, runs.map((run, k) => `${titles[k]}: ${steps ? stepsText(run) : "at the start"}`).join("; ")];
  }),
};
