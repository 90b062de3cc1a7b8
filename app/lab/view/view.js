/** How a moment looks: four images, the map of E, its curve, the joints and both robots in 3-D, in the lab and in
 * replays.
 * @import {Vector, Who, Stage} from "./space.js" @import {Picture} from "./images.js" @import {World} from "../engine/world.js"
 * @import {Line} from "../engine/affine.js"
 * @typedef {import("../engine/world.js").Scene & {stage: Stage, page?: {scene: string, layouts:
 * string[]}}} Scene page: how the page of viewimit names it
 * @typedef {{robot: import("./space.js").Common, hulls: Record<string, number[][]>}} Common of all scenes of a robot
 * @typedef {Picture & {rays: boolean, isChosen?: boolean}} Shown rays: whether each point is
 * joined with its images in 3-D; isChosen: whether the visitor chose the point */
import {backProject, transform, triangulate} from "../engine/engine.js";
import {Curve} from "./curve.js";
import {Images, outermost, silhouette} from "./images.js";
import {EnergyMap} from "./map.js";
import {Memory} from "./memory.js";
import {byId as $} from "./page.js";
import {Outside} from "./outside.js";
import {openSpace} from "./space.js";
import {drawingUnit, fixed, px, say, set} from "./svg.js";

const kept = new Memory(() => localStorage, "viewimit-"), IN_3D = "in-3d"; // what the browser keeps of a visitor who wants 3-D though it is slow
const NAMED = 1.32; // height of what must be in sight above an eye, for its name, times that of the eye
const PLATE_M = 0.17; // from a camera to its image plate, times the size of the scene
/** @type {Record<"points" | "chosen", [number, number]>} px and opacity of lines in 3-D */
const LINES = {points: [1.6, .8], chosen: [2.6, .9]};

export class View {
  /** @param {Common} common @param {ArrayBuffer} meshes @param {() => void} changed when a drawing's size has changed
   */
  constructor({robot, hulls}, meshes, changed) {
    this.images = new Images({L: $("L"), R: $("R"), l: $("l"), r: $("r")}, hulls);
    this.hulls = outermost(hulls);
    this.map = new EnergyMap($("map"));
    this.curve = new Curve($("curve"));
    this.space = opened(robot, meshes, () => this.flatten(true, changed));
    this.still = new Outside($("still"), hulls); // in place of the 3-D view, where WebGL is missing or slow
    this.isFlat = false;
    this.flatten(!this.space);
    $("in-3d").addEventListener("click", () => {
      kept.set(IN_3D, "1");
      this.flatten(false, changed);
    });
    this.azimuth = robot.view.azimuth;
    this.elevation = robot.view.elevation;
    this.isSpaceDue = false;
    /** @type {() => void} */
    this.show = () => {};
    this.scene = /** @type {Scene | null} */ (null);
    for (const [drawing, box] of /** @type {const} */ ([[this.images, $("images")], [this.curve, $("curve")]])) {
      drawing.measure();
      new ResizeObserver(() => { drawing.measure(); changed(); }).observe(box);
    }
    for (const [name, selector] of [["--head", "header"], ["--foot", ".bar"]]) {
      const element = /** @type {Element} */ (document.querySelector(selector)), root = document.documentElement;
      new ResizeObserver(() => root.style.setProperty(name, `${element.clientHeight}px`)).observe(element);
    }
  }

  /** Draw the scene without depth, or in 3-D. @param {boolean} on @param {() => void} [changed] */
  flatten(on, changed) {
    this.isFlat = on;
    document.body.classList.toggle("flat", on);
    $("still").hidden = !on;
    $("slow").hidden = !on || !this.space;
    if (on) this.space?.show(null);
    changed?.();
  }

  /** Where a point of the world is drawn in the scene, px. @param {ArrayLike<number>} point */
  place(point) {
    return this.isFlat || !this.space ? this.still.at(point).map(v => v * drawingUnit()) : this.space.project(point).slice(0, 2);
  }

  /** Another scene, or the same again. @param {Scene} scene */
  setScene(scene) {
    if (scene === this.scene) return;
    this.scene = scene;
    this.space?.setStage(scene.stage);
    this.images.fresh = true;
  }

  /** Images, scene and the words on the chosen point.
   * @param {World} world @param {Shown} shown
   * @returns {boolean} whether the windows of the images have still to move */
  draw(world, shown) {
    const moves = this.images.draw(world, shown);
    say($("residual"), residualOf(shown));
    $("ring").hidden = !shown.isChosen;
    $("unused").hidden = shown.moment.usable.length === world.body.length;
    this.drawSpace(world, shown);
    return moves;
  }

  /** Light or dark, in turn. @param {{resized: () => void}} shown is drawn again, with its map */
  recolour(shown) {
    const root = document.documentElement.dataset;
    root.scheme = root.scheme === "dark" ? "light" : "dark";
    this.space?.recolour();
    shown.resized();
  }

  /** @param {World} world @param {Shown} shown */
  drawSpace(world, {moment: {views, theta, thetaDemo}, recovered, lines, chosen, goal, rays}) {
    const {space, scene} = this;
    if (!scene) return;
    if (this.isFlat || !space) return this.#drawStill(world, theta, thetaDemo, goal);
    const {demonstrator, learner} = world.arms, N = world.body.length, each = Array.from({length: N}, (_, i) => i);
    const points = {
      demonstrator: triples(demonstrator.points(thetaDemo, world.body)),
      learner: triples(learner.points(theta, world.body)),
    };
    const plates = scene.cameras.map((camera, k) => each.map(i => {
      const [images, seen] = k < 2 ? [views.demo, views.demoSeen] : [views.own, views.ownSeen], at = 2 * i + (k & 1);
      if (!seen[at]) return null;
      return vector(backProject(camera, images[2 * at], images[2 * at + 1], PLATE_M * scene.stage.size));
    }));
    const found = each.map(i => Number.isFinite(recovered[4 * i])
      ? vector(triangulate(world.pairs.learner, recovered.subarray(4 * i, 4 * i + 4))) : null);
    const chosenPoints = scene.cameras.map((camera, k) => {
      const who = /** @type {Who} */ (k < 2 ? "demonstrator" : "learner");
      return strip(camera.centre, points[who][chosen], who, LINES.points);
    });
    this.#later(() => space.show({
      points, plates, rays, recovered: found,
      frames: {demonstrator: demonstrator.linkFrames(thetaDemo), learner: learner.linkFrames(theta)},
      painted: project => this.#outline(project, goal ? learner.linkFrames(thetaDemo) : null),
      lines: N ? [
        ...chosenPoints, ...lines.length ? rayOf(scene, points.demonstrator[chosen]) : [],
        ...lines.filter(({from}) => from === 0).flatMap(line => plated(scene, line)),
      ] : [],
    }));
  }

  /** The goal over the 3-D view, as in the pictures: a dashed outline.
   * @param {(p: ArrayLike<number>) => Vector} project to px, the third positive before the camera
   * @param {ArrayLike<number>[] | null} frames of the links */
  #outline(project, frames) {
    const outlines = frames ? this.hulls.map(({link, vertices}) => vertices.map(v => project(transform(frames[link], v)))) : [];
    const ahead = outlines.filter(corners => corners.every(([, , w]) => w > 0)).map(corners => silhouette(corners));
    set($("aim").firstElementChild, {d: ahead.map(corners => `M${corners.map(p => p.slice(0, 2).map(px).join(" ")).join("L")}z`).join("")});
  }

  /** Draw in 3-D, which may be slow, once the pictures and E are on the screen. @param {() => void} show */
  #later(show) {
    this.show = show;
    if (this.isSpaceDue) return;
    this.isSpaceDue = true;
    setTimeout(() => {
      this.isSpaceDue = false;
      if (!this.isFlat) this.show();
    });
  }

  /** @param {World} world @param {number[]} theta @param {number[]} thetaDemo @param {boolean} goal */
  #drawStill({arms, scene: {cameras}}, theta, thetaDemo, goal) {
    const {still} = this, frames = [arms.demonstrator.linkFrames(thetaDemo), arms.learner.linkFrames(theta)];
    still.measure();
    const landmarks = this.scene?.stage.landmarks ?? [];
    const above = cameras.map(({centre: [x, y, z]}) => [x, y, NAMED * z]);
    still.look(this.azimuth, this.elevation, [...landmarks, ...above]);
    const ghost = goal ? [{frames: arms.learner.linkFrames(thetaDemo), kind: "draw-guess"}] : [];
    const head = cameras[0].centre.map((v, i) => (v + cameras[1].centre[i]) / 2);
    const bases = [arms.demonstrator, arms.learner].map(({T_world_base: T}) => [T[3], T[7], T[11]]);
    const upright = (/** @type {number[]} */ top, /** @type {string} */ kind) =>
      /** @type {[number[], number[], string]} */ ([top, [top[0], top[1], 0], kind]);
    still.draw({
      bodies: [{frames: frames[0], kind: "vi-demo"}, ...ghost, {frames: frames[1], kind: ""}],
      eyes: cameras.map((camera, k) => ({camera, kind: k < 2 ? "vi-demo" : "", name: "lrLR"[k]})),
      lines: [upright(head, "still-pole"), ...bases.map(base => upright(base, "still-stand"))],
      labels: (this.scene?.stage.labels ?? []).filter(({text}) => text.length > 1)
        .map(({text, role, at}) => [at, text, `vi-b vi-mid still-${role}`]),
    }, "Both robots: the orange demonstrator, the blue learner, and the cameras that look at both.");
  }
}

/** The 3-D view, null without WebGL.
 * @param {import("./space.js").Common} robot @param {ArrayBuffer} meshes
 * @param {() => void} slow when its first frames have taken too long, unless a visitor wants it all the same */
function opened(robot, meshes, slow) {
  try { return openSpace($("space"), $("labels"), robot, meshes, kept.get(IN_3D) ? null : slow); } catch (error) { console.warn(error); }
  return null;
}

/** How far the chosen point's arrows reach. @param {Shown} shown */
function residualOf({moment: {views}, recovered, chosen}) {
  const off = (/** @type {number} */ k) => recovered[4 * chosen + k] - views.own[4 * chosen + k];
  const far = [Math.hypot(off(0), off(1)), Math.hypot(off(2), off(3))];
  return Number.isFinite(far[0] + far[1]) ? `point ${chosen}: e is ${fixed(far[0])} and ${fixed(far[1])} px long`
    : `point ${chosen} is not seen in all four pictures`;
}

/** @typedef {[Vector, Vector, string, number, number]} Strip a line in 3-D, as space.js takes it */

/** @param {ArrayLike<number>} from @param {ArrayLike<number>} to @param {string} role @param {[number, number]} how
 * @returns {Strip} */
const strip = (from, to, role, [width, opacity]) => [vector(from), vector(to), role, width, opacity];

/** The left camera's ray, on past the point: anything on it looks the same to that camera.
 * @param {Scene} scene @param {Vector} point @returns {Strip[]} */
function rayOf(scene, point) {
  if (!point) return [];
  const {centre} = scene.cameras[0];
  const on = (/** @type {number} */ share) => centre.map((c, i) => c + share * (point[i] - c));
  return [strip(on(.3), on(1.5), "chosen", LINES.chosen)];
}

/** An epipolar line, where it crosses the plate of its picture in the scene.
 * @param {Scene} scene @param {Line} line @returns {Strip[]} */
function plated(scene, {into, a, b, c}) {
  const camera = scene.cameras[into], {width, height} = camera;
  const inside = [[0, -c / b], [width, -(c + a * width) / b], [-c / a, 0], [-(c + b * height) / a, height]]
    .filter(([x, y]) => x >= 0 && x <= width && y >= 0 && y <= height);
  if (inside.length < 2) return [];
  const [from, to] = inside.map(([x, y]) => backProject(camera, x, y, PLATE_M * scene.stage.size));
  return [strip(from, to, "chosen", LINES.chosen)];
}

/** @param {ArrayLike<number>} p @returns {Vector} */
const vector = p => [p[0], p[1], p[2]];
/** @param {Float64Array} points (3 N) */
const triples = points => Array.from({length: points.length / 3}, (_, i) => vector(points.subarray(3 * i, 3 * i + 3)));
