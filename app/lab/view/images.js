/** The four images as SVG: silhouettes, points, transferred points, residuals and the lines of the chosen point.
 * @import {World} from "../engine/world.js" @import {Camera} from "../engine/camera.js" @import {Moment} from "../engine/session.js"
 * @import {Line} from "../engine/affine.js"
 * @typedef {{ellipses: {x: number, y: number, long: number, short: number, turn: number}[], steps: number[][][] |
 * null}} Construction of the chosen point: where noise of 1 px in l, r spreads it in L, R, and the steps to it;
 * ellipses: in L, R; px, turn in degrees; steps: in l, r, L, R: px
 * @typedef {Object} Picture the contents of one frame
 * @property {Pick<Moment, "theta" | "thetaDemo" | "views" | "usable" | "fitted">} moment
 * @property {Float64Array} recovered (4 N) px, NaN where not usable
 * @property {Line[]} lines of the chosen point
 * @property {number} chosen
 * @property {boolean} goal whether the learner is drawn as well as it would be in the demonstrator's pose
 * @property {number[][][] | null} [bones] the demonstrator's arm as it is transferred to L and R, px: null for none;
 *   computed from the moment if it is left out
 * @property {Construction | null} [construction]
 * @property {number} ease share of their way that the windows go to fit the drawing: 1 for the whole way at once */
import {projectPoint, transform} from "../engine/engine.js";
import {once} from "./once.js";
import {add, arrowPaths, circles, diamonds, dots, drawingSize, drawingUnit, polyline, px, set} from "./svg.js";

const VIEWS = /** @type {const} */ (["l", "r", "L", "R"]);
const MARGIN_PX = 13, MAX_SCALE = 4, NEAREST_M = 0.05, MAX_BEYOND = 0.3, TOUCH_PX = 18, MAX_HALF_AXIS = 400, TIP_PX = 5;
const COMPASS = Array.from({length: 16}, (_, k) => [Math.cos(k * Math.PI / 8), Math.sin(k * Math.PI / 8)]);
const LAYERS = ["vi-goal", "vi-goal-bone", "vi-hull", "vi-bone", "vi-line", "vi-line vi-from-right", "vi-line vi-partner",
  "vi-spread", "vi-steps", "vi-stop", "vi-goal-dot", "vi-bone vi-found", "vi-e", "vi-tip", "vi-own",
  "vi-own vi-unused", "vi-seen", "vi-seen vi-unused", "vi-found", "vi-ring"];

/** @typedef {{hulls: number[][][], bones: number[][]}} Outline of an arm in one image, px */
/** @typedef {{x: number, y: number, scale: number}} Window the image's point at the drawing's corner, and drawing px
 * per px */

/** @param {Record<string, number[][]>} hulls outermost vertices of links, by their number */
export const outermost = hulls => Object.entries(hulls).map(([link, vertices]) => ({link: Number(link), vertices}));

/** The outline of each link in a drawing.
 * @param {ReturnType<typeof outermost>} hulls @param {ArrayLike<number>[]} frames T_world_link
 * @param {(p: number[]) => number[]} see from the world to the drawing */
export const silhouettes = (hulls, frames, see) =>
  hulls.map(({link, vertices}) => silhouette(vertices.map(v => see(transform(frames[link], v)))));

/** A convex outline: the outermost points in sixteen directions. @param {number[][]} points @returns {number[][]} */
export const silhouette = points => COMPASS.map(([a, b]) => {
  let best = points[0], most = -Infinity;
  for (const p of points) {
    const along = a * p[0] + b * p[1];
    if (along > most) [most, best] = [along, p];
  }
  return best;
});

/** Outlines of arms, computed again only where a posture or the scene has changed. */
export class Outlines {
  /** @param {Record<string, number[][]>} hulls outermost vertices of links */
  constructor(hulls) {
    this.hulls = outermost(hulls);
  }

  /** Silhouettes of the links and the line through their origins, in both images.
   * @param {World} world @param {"demonstrator" | "learner"} who @param {ArrayLike<number>} theta
   * @param {string} name under which the last one is kept @returns {Outline[]} */
  of(world, who, theta, name) {
    return once(world.scene, `${who} ${name}`, () => {
      const frames = world.arms[who].linkFrames(theta);
      return world.pairs[who].map(camera => ({
        hulls: silhouettes(this.hulls, frames, p => projectPoint(camera, p, NEAREST_M)),
        bones: frames.map(T => projectPoint(camera, [T[3], T[7], T[11]], NEAREST_M)),
      }));
    }, Array.from(theta).join());
  }
}

export class Images {
  /** @param {Record<string, HTMLElement>} boxes by view: all or some
   * @param {Record<string, number[][]>} hulls outermost vertices of links */
  constructor(boxes, hulls) {
    this.outlines = new Outlines(hulls);
    this.views = VIEWS.map((view, k) => ({view, k})).filter(({view}) => boxes[view]).map(({view, k}) => {
      const svg = add(boxes[view], "svg", {class: `vi${k < 2 ? " vi-demo" : ""}`, role: "img"});
      const plane = add(svg, "rect", {class: "vi-plane", x: .5, y: .5, rx: 5}), frame = add(svg, "rect", {class: "vi-rule"});
      const layers = LAYERS.map(name => add(svg, "path", {class: name}));
      add(svg, "rect", {class: "vi-behind", x: 1, y: 1, width: 23, height: 23, rx: 5});
      const name = add(svg, "text", {class: "vi-name", x: 8, y: 18});
      name.textContent = view;
      /** @type {Window} */
      const window = {x: 0, y: 0, scale: 0};
      return {view, k, svg, box: boxes[view], plane, frame, layers, window, width: 1, height: 1};
    });
    this.unit = 1; // px of a drawing's unit
    this.fresh = true; // whether the windows have to fit at once
    this.held = /** @type {Outline[][] | null} */ (null); // what the windows of L and R hold instead of what they show
  }

  /** Let the windows of L and R hold these postures of the learner, and stay. @param {World} world @param {number[][]} postures rad */
  hold(world, postures) {
    this.held = postures.map((theta, k) => this.outlines.of(world, "learner", theta, `held ${k}`));
    this.fresh = true;
  }

  /** The sizes of the drawings are those of their boxes. */
  measure() {
    this.unit = drawingUnit();
    for (const view of this.views) {
      const {width, height} = drawingSize(view.box);
      Object.assign(view, {width, height});
      set(view.svg, {viewBox: `0 0 ${view.width} ${view.height}`});
      set(view.plane, {width: view.width - 1, height: view.height - 1});
    }
    this.fresh = true;
  }

  /** @param {World} world @param {Picture} picture @returns {boolean} whether the windows have still to move */
  draw(world, picture) {
    const {moment} = picture, ease = this.fresh ? 1 : picture.ease;
    const demo = this.outlines.of(world, "demonstrator", moment.thetaDemo, "demo");
    const own = this.outlines.of(world, "learner", moment.theta, "own");
    const goal = this.outlines.of(world, "learner", moment.thetaDemo, "goal");
    const shown = picture.goal ? [own, goal] : [own];
    const moves = [this.#fit(0, [demo], ease), this.#fit(2, this.held ?? shown, ease, this.held ? undefined : picture.recovered)]
      .some(Boolean);
    this.fresh = false;
    const goalImages = picture.goal ? world.look("learner", moment.thetaDemo).images : null;
    const bones = picture.bones === undefined ? this.#recoveredBones(moment, demo) : picture.bones;
    for (const view of this.views) {
      const side = view.k & 1, isDemo = view.k < 2;
      this.#drawView(view, world.scene.cameras[view.k], picture, (isDemo ? demo : own)[side], isDemo || !picture.goal ? null : goal[side], goalImages, isDemo ? null : bones?.[side] ?? null);
    }
    return moves;
  }

  /** A point under a finger. @param {PointerEvent} event @returns {{view: number, point: number} | null} */
  hit(event, /** @type {Pick<Moment, "views">} */ {views}) {
    const view = this.views.find(({svg}) => svg.contains(/** @type {Node} */ (event.target)));
    if (!view) return null;
    const [x, y] = this.under(event, view.k), images = view.k < 2 ? views.demo : views.own;
    let point = -1, least = TOUCH_PX / this.unit / view.window.scale;
    for (let i = 0; i < images.length / 4; i++) {
      const away = Math.hypot(images[4 * i + 2 * (view.k & 1)] - x, images[4 * i + 2 * (view.k & 1) + 1] - y);
      if (away < least) [point, least] = [i, away];
    }
    return point < 0 ? null : {view: view.k, point};
  }

  /** The image's px under a pointer. @param {PointerEvent} event @param {number} k the view */
  under(event, k) {
    const {svg, window: {x, y, scale}} = this.view(k), box = svg.getBoundingClientRect();
    return [(event.clientX - box.left) / this.unit / scale + x, (event.clientY - box.top) / this.unit / scale + y];
  }

  /** @param {number} k 0 … 3 for l, r, L, R, of which there must be a box */
  view(k) { return /** @type {Images["views"][number]} */ (this.views.find(view => view.k === k)); }

  /** Where a place of an image is drawn, in its drawing's units.
   * @param {number} k the view @param {number} x px @param {number} y px @returns {[number, number]} */
  place(k, x, y) {
    const {window} = this.view(k);
    return [(x - window.x) * window.scale, (y - window.y) * window.scale];
  }

  /** The demonstrator's skeleton as the transfer puts it into the learner's views.
   * @param {Pick<Moment, "fitted">} moment @param {Outline[]} demo */
  #recoveredBones({fitted}, demo) {
    if (!fitted) return null;
    const joints = demo[0].bones.map((p, i) => [p[0], p[1], demo[1].bones[i][0], demo[1].bones[i][1]]);
    const found = fitted.recover(Float64Array.from(joints.flat()));
    return [0, 2].map(from => joints.map((_, i) => [found[4 * i + from], found[4 * i + from + 1]]));
  }

  /** Move a pair's windows to what they show. @param {number} first @param {Outline[][]} bodies @param {number} ease @param {Float64Array} [marks] (4 N) px, far ones among them */
  #fit(first, bodies, ease, marks) {
    const pair = this.views.filter(({k}) => k >> 1 === first >> 1);
    const spans = pair.map(({k}) => {
      const points = bodies.flatMap(body => [...body[k & 1].hulls.flat(), ...body[k & 1].bones]);
      const xs = points.map(p => p[0]), ys = points.map(p => p[1]);
      const body = [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)], span = [...body];
      for (let i = 2 * (k & 1); marks && i < marks.length; i += 4) if (Number.isFinite(marks[i])) [0, 1].forEach(axis => {
        const far = MAX_BEYOND * (body[axis + 2] - body[axis]);
        span[axis] = Math.min(span[axis], Math.max(marks[i + axis], body[axis] - far));
        span[axis + 2] = Math.max(span[axis + 2], Math.min(marks[i + axis], body[axis + 2] + far));
      });
      return span;
    });
    const scale = Math.min(MAX_SCALE, ...pair.map(({width, height}, k) => Math.min(
      (width - 2 * MARGIN_PX) / Math.max(spans[k][2] - spans[k][0], 1), (height - 2 * MARGIN_PX) / Math.max(spans[k][3] - spans[k][1], 1))));
    let off = 0;
    pair.forEach((view, k) => {
      const [x0, y0, x1, y1] = spans[k], {window} = view;
      const target = {x: (x0 + x1) / 2 - view.width / scale / 2, y: (y0 + y1) / 2 - view.height / scale / 2, scale};
      const share = window.scale ? ease : 1;
      for (const name of /** @type {const} */ (["x", "y", "scale"])) window[name] += share * (target[name] - window[name]);
      off = Math.max(off, Math.abs(target.x - window.x) + Math.abs(target.y - window.y), 60 * Math.abs(target.scale - window.scale));
    });
    return off > .3;
  }

  /** @param {Images["views"][number]} view @param {Camera} camera @param {Picture} picture @param {Outline} outline
   * @param {Outline | null} ghost @param {Float64Array | null} goalImages @param {number[][] | null} bones */
  #drawView(view, camera, {moment, recovered, lines, chosen, construction}, outline, ghost, goalImages, bones) {
    const {x, y, scale} = view.window, side = view.k & 1, isDemo = view.k < 2, {views} = moment;
    const images = isDemo ? views.demo : views.own, seen = isDemo ? views.demoSeen : views.ownSeen;
    const at = (/** @type {ArrayLike<number>} */ p) => [(p[0] - x) * scale, (p[1] - y) * scale];
    const closed = (/** @type {number[][][]} */ hulls) => hulls.map(points => `${polyline(points.map(at))}z`).join("");
    const used = new Set(moment.usable), all = Array.from({length: images.length / 4}, (_, i) => i);
    const of = (/** @type {Float64Array} */ images, points = all) =>
      points.map(i => at(images.subarray(4 * i + 2 * side, 4 * i + 2 * side + 2))).filter(p => Number.isFinite(p[0]));
    const shown = all.filter(i => seen[2 * i + side]), [usable, unused] = [true, false].map(is => of(images, shown.filter(i => used.has(i) === is)));
    const crossed = unused.map(([a, b]) => `M${px(a - 3)} ${px(b - 3)}l6 6m0-6l-6 6`).join("");
    /** @type {Record<string, string>} */
    const d = {"vi-hull": closed(outline.hulls), "vi-bone": polyline(outline.bones.map(at))};
    if (isDemo) {
      d["vi-seen"] = diamonds(usable, 3.6);
      d["vi-seen vi-unused"] = crossed;
    } else {
      const found = all.filter(i => Number.isFinite(recovered[4 * i + 2 * side]));
      if (ghost) [d["vi-goal"], d["vi-goal-bone"]] = [closed(ghost.hulls), polyline(ghost.bones.map(at))];
      if (goalImages) d["vi-goal-dot"] = dots(of(goalImages));
      d["vi-own"] = dots(usable);
      d["vi-own vi-unused"] = crossed;
      d["vi-found"] = diamonds(of(recovered, found), 3.9);
      if (bones) d["vi-bone vi-found"] = polyline(bones.map(at));
      const own = of(images, found);
      [d["vi-e"], d["vi-tip"]] = arrowPaths(of(recovered, found).map((p, k) => [p, own[k]]), TIP_PX);
    }
    const stops = construction?.steps?.[view.k];
    if (stops) {
      d["vi-steps"] = polyline(stops.map(at));
      d["vi-stop"] = dots(stops.slice(0, -1).map(at));
    }
    const spread = isDemo ? null : construction?.ellipses[side];
    if (spread) {
      const [a, b] = [spread.long, spread.short].map(half => Math.min(half * scale, MAX_HALF_AXIS));
      const turn = spread.turn * Math.PI / 180;
      const [u, v, arc] = [a * Math.cos(turn), a * Math.sin(turn), `a${px(a)} ${px(b)} ${spread.turn} 0 1 `];
      const [mx, my] = [(spread.x - x) * scale, (spread.y - y) * scale];
      d["vi-spread"] = `M${px(mx - u)} ${px(my - v)}${arc}${px(2 * u)} ${px(2 * v)}${arc}${px(-2 * u)} ${px(-2 * v)}z`;
    }
    const ringed = [images[4 * chosen + 2 * side], images[4 * chosen + 2 * side + 1]];
    if (seen[2 * chosen + side]) d["vi-ring"] = circles([at(ringed)], isDemo ? 8 : 10);
    for (const {into, from, a, b, c} of lines) if (into === view.k) {
      const kind = from >> 1 === into >> 1 ? "vi-line vi-partner" : from & 1 ? "vi-line vi-from-right" : "vi-line";
      const middle = [x + view.width / scale / 2, y + view.height / scale / 2], off = a * middle[0] + b * middle[1] + c;
      const [fx, fy, half] = [middle[0] - a * off, middle[1] - b * off, 1000];
      d[kind] = (d[kind] ?? "") + polyline([at([fx - b * half, fy + a * half]), at([fx + b * half, fy - a * half])]);
    }
    view.layers.forEach((layer, k) => set(layer, {d: d[LAYERS[k]] ?? ""}));
    set(view.frame, {x: px(-x * scale), y: px(-y * scale), width: px(camera.width * scale), height: px(camera.height * scale)});
    const e = [recovered[4 * chosen + 2 * side] - ringed[0], recovered[4 * chosen + 2 * side + 1] - ringed[1]], length = Math.hypot(e[0], e[1]);
    set(view.svg, {"aria-label": isDemo ? `Image ${view.view}: the demonstrator seen by the ${side ? "right" : "left"} eye`
      : `Image ${view.view}: the learner's own arm; residual of point ${chosen}: ${Number.isFinite(length) ? length.toFixed(1) : "no"} px`});
  }
}
