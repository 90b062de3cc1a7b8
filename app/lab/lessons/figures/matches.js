/** Maps of E with all matches, with few of them, and with all of them nearly in a plane; and which points are matched.
 * @import {Stage, FigureKind} from "../stage.js" @import {Landscape} from "../../engine/landscape.js"
 * @import {World} from "../../engine/world.js" */
import {centred} from "../../engine/affine.js";
import {dot, symmetricEigen} from "../../engine/algebra.js";
import {projectPoint, select} from "../../engine/engine.js";
import {Altered, mapOf, medianCondition} from "../maps.js";
import {diamonds, Drawing, fitted, path, polyline, rectangle} from "./drawing.js";
import {inline, make} from "../dom.js";
import {once} from "../../view/once.js";
import {MapPanel} from "./panels.js";

const FEWEST = 4, STEP_DEG = 1.5;
const LEFT_OF_DEPTH = .1; // of the points' distances from the plane: exactly in it, rounding would shape the map
const FLAT = 1e-9; // of the largest E with all matches: below, a map is rounding
const MOST_MINIMA = 60, TRANSFER = "epipolar";

/** @type {FigureKind} */
export const MATCHES = {
  layers: ["all", "few", "plane"],
  title: "Maps of E with other matches",
  aspect: 1.5,
  create(box) {
    box.classList.add("bare", "lesson-panels");
    const all = new MapPanel(box), few = new MapPanel(box), body = pointsPanel(box), plane = new MapPanel(box);
    return {
      resize() {
        for (const panel of [all, few, body, plane]) panel.resize();
      },
      draw(stage, layers) {
        const {scene} = stage.world, shown = matchesShown(stage), whole = mapOfFirst(stage, total(stage));
        const demonstrator = stage.truthHidden ? null : stage.moment.thetaDemo;
        const hidden = {map: null, demonstrator: null, lowest: []};
        all.box.hidden = !layers.has("all");
        few.box.hidden = !layers.has("few");
        plane.box.style.visibility = layers.has("plane") ? "" : "hidden";
        if (layers.has("all")) all.draw({title: `All ${total(stage)} matches`, ...relief(whole), demonstrator}, scene);
        if (layers.has("few")) {
          const title = `${shown} matches`, made = stage.isRevealed ? mapOfFirst(stage, shown) : null;
          if (!made) few.draw({title, words: "", instead: "?", ...hidden}, scene);
          else if (isFlat(made.landscape, whole.landscape))
            few.draw({title, words: "every pose fits", instead: "E is 0 at every pose", ...hidden}, scene);
          else few.draw({title, ...relief(made), demonstrator}, scene);
        }
        body.draw(stage, shown);
        const title = `${total(stage)} matches, nearly in a plane`;
        if (layers.has("plane")) plane.draw({title, ...relief(planeMap(stage)), demonstrator}, scene);
      },
    };
  },
};

/** @param {{landscape: Landscape, key: string}} map */
function relief(map) {
  const lowest = localMinima(map.landscape), many = lowest.length === 1 ? "one minimum" : `${lowest.length} minima`;
  const most = Number(largest(map.landscape).toPrecision(3)).toLocaleString("en").replace(/,/g, "\u2009");
  return {map, lowest: lowest.slice(0, MOST_MINIMA), words: `${many}; E up to ${most} px²`};
}

/** The demonstrator's points in l: those that are matched are filled. @param {HTMLElement} within */
function pointsPanel(within) {
  const note = make("span"), box = make("div", {class: "lesson-plain"});
  within.append(make("div", {class: "lesson-panel"},
    make("div", {class: "lesson-panel-head"}, make("b", {html: inline("What is matched, in l")}), note), box));
  const drawing = new Drawing(box, "");
  return {
    resize: () => drawing.measure(),
    /** @param {Stage} stage @param {number} count */
    draw(stage, count) {
      const {demo} = stage.moment.views, matched = bestOrder(stage).slice(0, count), {width, height} = drawing;
      const frames = stage.world.arms.demonstrator.linkFrames(stage.moment.thetaDemo);
      const bones = frames.map(T => projectPoint(stage.world.pairs.demonstrator[0], [T[3], T[7], T[11]]));
      const points = stage.world.body.map((_, i) => [demo[4 * i], demo[4 * i + 1]]), all = [...bones, ...points];
      const {place} = fitted(all, [15, 15, width - 15, height - 15]);
      const left = points.filter((_, i) => !matched.includes(i)).map(place);
      note.textContent = left.length ? "hollow: left out" : "";
      const arm = `<g class="vi-demo">${path("vi-bone lesson-quiet", polyline(bones.map(place)))}</g>`;
      drawing.show(rectangle("vi-plane", .5, .5, width - 1, height - 1, 5) + arm
        + path("lesson-unmatched", diamonds(left, 5))
        + path("vi-seen", diamonds(matched.map(i => place(points[i])), 6)),
      `Image l: ${matched.length} of ${points.length} points of the demonstrator are matched`);
    },
  };
}

/** @param {Stage} stage */
const total = stage => bestOrder(stage).length;

/** How many matches are used: few before the answer, then as the slider says. @param {Stage} stage */
const matchesShown = stage => stage.isRevealed ? Math.round(stage.sliders.get("matches") ?? FEWEST) : FEWEST;

/** The points as they are added: the four whose shape is the least flat, by the third singular value, then one after
 * the other the one that makes it least flat.
 * @param {Stage} stage @returns {number[]} */
export const bestOrder = stage => once(stage.world, "order", () => ordered(stage));

/** @param {Stage} stage */
function ordered({moment: {views, usable}}) {
  const depth = (/** @type {number[]} */ points) => {
    const away = centred(select(views.demo, points)), W = new Float64Array(16);
    for (let i = 0; i < away.length; i += 4) for (let p = 0; p < 4; p++) for (let q = 0; q < 4; q++)
      W[4 * p + q] += away[i + p] * away[i + q];
    return [...symmetricEigen(W, 4).values].sort((a, b) => b - a)[2];
  };
  const best = (/** @type {number[][]} */ sets) => sets.map(set => ({set, depth: depth(set)}))
    .reduce((a, b) => b.depth > a.depth ? b : a).set;
  let chosen = best(subsets(usable, Math.min(FEWEST, usable.length)));
  while (chosen.length < usable.length) chosen = best(usable.filter(i => !chosen.includes(i)).map(i => [...chosen, i]));
  return chosen;
}

/** @param {number[]} of @param {number} count @returns {number[][]} */
function subsets(of, count) {
  if (!count) return [[]];
  return of.flatMap((first, k) => subsets(of.slice(k + 1), count - 1).map(rest => [first, ...rest]));
}

/** @param {World} world @param {string} name @param {() => World["body"]} body */
const worldWith = (world, name, body) => once(world, `with ${name}`, () => new Altered(world, {body: body()}));

/** The map with the first points of the order. @param {Stage} stage @param {number} count */
export function mapOfFirst(stage, count) {
  const body = () => bestOrder(stage).slice(0, count).map(i => stage.world.body[i]);
  const world = worldWith(stage.world, String(count), body);
  return mapOf(world, TRANSFER, world.look("demonstrator", stage.moment.thetaDemo), STEP_DEG);
}

/** The world with all points nearly in the plane in which the arm moves. @param {Stage} stage */
function flatWorld(stage) { return worldWith(stage.world, "plane", () => pressed(stage)); }

/** @param {Stage} stage */
function planeMap(stage) {
  const world = flatWorld(stage);
  return mapOf(world, TRANSFER, world.look("demonstrator", stage.moment.thetaDemo), STEP_DEG);
}

/** The points, moved on their links towards the plane through their middle in which the arm moves.
 * @param {Stage} stage @returns {World["body"]} */
function pressed({world, moment}) {
  const arm = world.arms.demonstrator, theta = moment.thetaDemo, frames = arm.frames(theta), normal = [0, 0, 0];
  arm.joints.forEach(({axis}, k) => {
    const T = frames[k + 1], turned = [0, 4, 8].map(i => T[i] * axis[0] + T[i + 1] * axis[1] + T[i + 2] * axis[2]);
    const sign = dot(turned, normal) < 0 ? -1 : 1;
    turned.forEach((v, i) => normal[i] += sign * v);
  });
  const all = arm.points(theta, world.body), points = world.body.map((_, i) => [...all.subarray(3 * i, 3 * i + 3)]);
  const unit = normal.map(v => v / Math.hypot(...normal)), mean = dot(unit, [0, 1, 2].map(k => average(points, k)));
  return world.body.map(({on}, i) => {
    const away = dot(points[i], unit) - mean, T = frames[on];
    const q = points[i].map((v, k) => v - (1 - LEFT_OF_DEPTH) * away * unit[k] - T[4 * k + 3]);
    return {on, at: [0, 1, 2].map(k => T[k] * q[0] + T[k + 4] * q[1] + T[k + 8] * q[2])};
  });
}

/** @param {number[][]} points @param {number} k coordinate */
const average = (points, k) => points.reduce((sum, p) => sum + p[k], 0) / points.length;

/** The largest E, px². @param {Landscape} map */
const largest = ({E}) => E.reduce((most, v) => v > most ? v : most, 0);

/** Whether E is zero everywhere, up to rounding. @param {Landscape} map @param {Landscape} like one that is not */
const isFlat = (map, like) => largest(map) < FLAT * largest(like);

/** The postures below all their neighbours, rad, the lowest first. @param {Landscape} map */
function localMinima(map) {
  const rows = map.axes[0].length, columns = map.axes[1].length, {E} = map, found = [];
  for (let i = 0; i < rows; i++) for (let j = 0; j < columns; j++) {
    const here = E[i * columns + j];
    let isLowest = Number.isFinite(here);
    for (let a = Math.max(i - 1, 0); isLowest && a <= Math.min(i + 1, rows - 1); a++)
      for (let b = Math.max(j - 1, 0); isLowest && b <= Math.min(j + 1, columns - 1); b++)
        isLowest = (a === i && b === j) || !(E[a * columns + b] <= here);
    if (isLowest) found.push(i * columns + j);
  }
  return found.sort((a, b) => E[a] - E[b]).map(g => map.posture(g));
}

/** The largest E with the first points, px²; 0 for rounding. @param {Stage} stage @param {number} count 0 for all */
export function largestOf(stage, count) {
  const whole = mapOfFirst(stage, total(stage)).landscape, map = count ? mapOfFirst(stage, count).landscape : whole;
  return isFlat(map, whole) ? 0 : largest(map);
}

/** The median of cond(A) over all postures. @param {Stage} stage @param {boolean} flat whether points are in a plane */
export function conditionOf(stage, flat) {
  const world = flat ? flatWorld(stage) : stage.world;
  return medianCondition(world, TRANSFER, world.look("demonstrator", stage.moment.thetaDemo), STEP_DEG);
}
