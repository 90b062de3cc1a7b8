/** Cameras and what they look at, from outside: a mark on a stick that slides along a ray of camera 1, an arm with the
 * rays of three marks, or both arms with the eyes between them.
 * @import {Stage, FigureKind, Mark} from "../stage.js" @import {Camera} from "../../engine/camera.js" */
import {Outside} from "../../view/outside.js";
import {add, px} from "../../view/svg.js";
import {camerasOf, FIRST_SHARE, LAST_SHARE, MARKS, markOf, marksOf, onRay, OUTSIDE, outsideMark, PLACES, sliding,
  targetOf} from "../rays.js";
import {Names} from "./names.js";
import {circles} from "./drawing.js";

const FLOOR_M = 0.5; // from line to line
const NAME_PX = 13, SMALL_PX = 300, SMALL_SIDE = 170, SHORT_BELOW = 340; // drawings that are smaller have shorter names, or fewer
const BEHIND = {azimuth: Math.PI + .45, elevation: .4}; // where the spectator of both arms stands, rad: behind the eyes
const HOLDS_AT_MOST = 3; // times their usual distance up to which the cameras stay in sight

/** @type {FigureKind} */
export const outside = {
  layers: ["cameras", "stick", "arm", "ray", "sliding mark", "three rays", "arms", "eyes", "guess"],
  title: "**From outside**",
  aspect: 0.95,
  create: (box, stage) => new Room(box, stage),
};

class Room {
  /** @param {HTMLElement} box @param {Stage} stage */
  constructor(box, stage) {
    this.outside = new Outside(box, stage.page.hulls);
    this.over = add(this.outside.svg, "g");
    this.floor = add(this.outside.svg, "path", {class: "draw-floor"});
    this.outside.svg.insertBefore(this.floor, this.outside.inside);
    this.last = "";
    this.resize();
  }

  resize() { this.outside.measure(); }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const html = layers.has("arms") ? this.#both(stage, layers) : this.#cameras(stage, layers);
    this.floor.setAttribute("d", this.#grid());
    if (html !== this.last) this.over.innerHTML = this.last = html;
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  #cameras(stage, layers) {
    const {outside: view} = this, {world} = stage, demonstrator = world.arms.demonstrator;
    const cameras = camerasOf(stage), theta = stage.moment.thetaDemo;
    const hasArm = layers.has("three rays") || layers.has("arm");
    const usual = camerasOf(stage, Math.min(HOLDS_AT_MOST, stage.sliders.get("camera distance") ?? 1));
    const mark = markOf(world), foot = (/** @type {ArrayLike<number>} */ p) => [p[0], p[1], 0];
    const ends = [FIRST_SHARE, LAST_SHARE].map(share => onRay(cameras[0], mark, share)), target = targetOf(stage);
    const base = demonstrator.T_world_base, stands = [base[3], base[7], 0];
    view.look(OUTSIDE.azimuth, OUTSIDE.elevation, [
      ...usual.map(camera => camera.centre), ...usual.map(({centre: [x, y, z]}) => [x, y, z + .22]),
      ...hasArm ? [target, stands, [target[0] + .3, target[1], 0], [target[0], target[1], 1.1]]
        : [...ends, ...ends.map(foot)],
    ]);
    view.draw({
      bodies: hasArm ? [{frames: demonstrator.linkFrames(theta), kind: "vi-demo"}] : [],
      eyes: layers.has("cameras") ? cameras.map((camera, k) => ({camera, kind: k ? "" : "vi-demo", name: ""})) : [],
    }, this.#label(stage, layers));
    return this.#over(stage, layers, cameras);
  }

  /** Both arms, and the eyes that turn from one to the other. @param {Stage} stage @param {Set<string>} layers */
  #both(stage, layers) {
    const {outside: view} = this, {arms, scene} = stage.world, {theta, thetaDemo} = stage.moment, {cameras} = scene;
    const head = cameras[0].centre.map((v, i) => (v + cameras[1].centre[i]) / 2), foot = [head[0], head[1], 0];
    const stands = (/** @type {"demonstrator" | "learner"} */ who) => [3, 7, 11].map(k => arms[who].T_world_base[k]);
    const bases = [stands("demonstrator"), stands("learner")];
    const frames = [arms.demonstrator.linkFrames(thetaDemo), arms.learner.linkFrames(theta)];
    const reach = frames.flat().flatMap(T => [-.16, .16].map(d => [T[3], T[7] + d, T[11] + d]));
    view.look(BEHIND.azimuth, BEHIND.elevation, [foot, [head[0], head[1], head[2] + .3], ...reach,
      ...bases.flatMap(([x, y, z]) => [[x, y - .3, -.15], [x, y + .3, -.15], [x, y, z + .85]])]);
    const guess = layers.has("guess") ? [{frames: arms.learner.linkFrames(stage.guessed), kind: "draw-guess"}] : [];
    view.draw({
      bodies: [{frames: frames[0], kind: "vi-demo"}, {frames: frames[1], kind: ""}, ...guess],
      eyes: layers.has("eyes") ? cameras.map((camera, k) => ({camera, kind: k < 2 ? "vi-demo" : "", name: ""})) : [],
    }, `From outside: the orange demonstrator, the blue learner, and ` +
      `${layers.has("eyes") ? "the two eyes on a pole that look at both" : "the room"}.`);
    const names = new Names([0, 0, view.width, view.height]);
    const at = (/** @type {ArrayLike<number>} */ p) => view.at(p);
    for (const body of frames) body.slice(1).forEach((T, k) =>
      names.keepLine([at([body[k][3], body[k][7], body[k][11]]), at([T[3], T[7], T[11]])], 18));
    const bars = layers.has("eyes") ? [[0, 1], [2, 3]]
      .map(([l, r]) => [cameras[l].centre, cameras[r].centre, "draw-bar"]) : [];
    const lines = [[head, foot, "draw-pole"], ...bars,
      ...bases.map(base => [base, [base[0], base[1], 0], "draw-pole draw-faint"])];
    if (layers.has("eyes")) for (const base of bases) lines.push([head, [base[0], base[1], base[2] + .4], "draw-gaze"]);
    let html = "";
    for (const [from, to, kind] of /** @type {[number[], number[], string][]} */ (lines)) {
      html += `<path class="${kind}" d="M${at(from).map(px).join(" ")}L${at(to).map(px).join(" ")}"/>`;
      names.keepLine([at(from), at(to)], 3);
    }
    const size = Math.min(view.width, view.height) < SMALL_SIDE ? 11 : NAME_PX;
    names.put("demonstrator", at([bases[0][0], bases[0][1], 0]), "vi-of-demo", {size, away: 8, first: [0, 1]});
    names.put("learner", at([bases[1][0], bases[1][1], 0]), "vi-of-own", {size, away: 8, first: [0, 1]});
    if (layers.has("eyes")) {
      cameras.forEach(camera => {
        names.keep(at(camera.centre), 8);
        names.keep(at(onAxis(camera, .12)), .09 * view.window.scale);
      });
      const eyes = view.width < SHORT_BELOW ? "two eyes" : "two eyes, turned to each arm";
      if (size === NAME_PX) names.put(eyes, at(head), "draw-ink", {away: 12, first: [0, -1]});
    }
    return html + names.html;
  }

  /** @param {Stage} stage @param {Set<string>} layers @param {Camera[]} cameras */
  #over(stage, layers, cameras) {
    const {outside: view} = this, {world} = stage, at = (/** @type {ArrayLike<number>} */ p) => view.at(p);
    const names = new Names([0, 0, view.width, view.height]);
    const isSmall = view.width < SMALL_PX || view.height < SMALL_SIDE, {reveal} = stage;
    const segment = (/** @type {ArrayLike<number>} */ p, /** @type {ArrayLike<number>} */ q) => {
      names.keepLine([at(p), at(q)], 2);
      return `M${at(p).map(px).join(" ")}L${at(q).map(px).join(" ")}`;
    };
    let html = "";
    if (layers.has("cameras")) cameras.forEach(camera => {
      const plate = at(onAxis(camera, .16));
      names.keepLine([at(camera.centre), plate], 12);
    });
    const draws = (/** @type {string} */ kind,
      /** @type {string} */ d) => { html += `<path class="${kind}" d="${d}"/>`; };
    if (layers.has("three rays")) {
      const marks = marksOf(stage);
      marks.forEach(p => draws("draw-ray", segment(cameras[0].centre, p)));
      marks.forEach((p, k) => {
        draws("draw-mark-dot", circles([at(p)], 5));
        names.keep(at(p), 7);
        if (!isSmall) names.put(MARKS[k], at(p), "vi-chosen", {away: 8});
      });
    }
    const mark = markOf(world), foot = (/** @type {ArrayLike<number>} */ p) => [p[0], p[1], 0];
    const slide = sliding(reveal), now = layers.has("sliding mark") ? onRay(cameras[0], mark, slide.share) : mark;
    if (layers.has("ray")) {
      const grown = Math.min(1, 6 * reveal);
      const to = onRay(cameras[0], mark, FIRST_SHARE + grown * (LAST_SHARE - FIRST_SHARE));
      draws("draw-ray-case", segment(cameras[0].centre, to));
      draws("draw-ray", segment(cameras[0].centre, to));
      if (grown === 1) names.put("the ray", at(onRay(cameras[0], mark, .28)), "vi-chosen",
        {size: NAME_PX, away: 8, first: [-1, 1]});
    }
    if (layers.has("sliding mark")) for (const share of PLACES.filter(place => slide.passed(place))) {
      const place = onRay(cameras[0], mark, share);
      draws("draw-sight", segment(cameras[1].centre, place));
      draws("draw-stick draw-faint", segment(foot(place), place));
      draws("draw-place", circles([at(place)], 5));
      names.keep(at(place), 6);
    }
    if (layers.has("stick")) {
      draws("draw-stick", segment(foot(now), now));
      draws("draw-foot", circles([at(foot(now))], 2.5));
      draws("draw-mark-dot", circles([at(now)], isSmall ? 6 : 8));
      names.keep(at(now), 8);
      if (!(slide.isMoving && layers.has("sliding mark")))
        names.put("the mark", at(now), "vi-chosen", {size: NAME_PX, away: 12, first: [1, -1]});
    }
    if (layers.has("cameras")) cameras.forEach((camera, k) => {
      const [x, y] = at(camera.centre);
      if (x > 0 && y > 0 && x < view.width && y < view.height) names.put(isSmall ? String(k + 1) : `camera ${k + 1}`,
        at(camera.centre), "draw-ink", {size: isSmall ? 15 : NAME_PX, away: 12, first: [0, -1]});
    });
    return html + names.html;
  }

  /** Lines on the floor, all over the drawing. */
  #grid() {
    const {outside: view} = this;
    const at = (/** @type {number} */ x, /** @type {number} */ y) => view.at([x, y, 0]).map(px).join(" ");
    let d = "";
    for (let k = -12; k <= 16; k++) {
      const v = k * FLOOR_M;
      d += `M${at(v, -6)}L${at(v, 8)}M${at(-6, v)}L${at(8, v)}`;
    }
    return d;
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  #label({reveal}, layers) {
    if (layers.has("three rays"))
      return "From outside: two cameras look at an arm. Three rays go from camera 1 to three marks on it.";
    if (!layers.has("ray")) return "From outside: two cameras look at a mark on a stick.";
    return `From outside: the ray of camera 1 through the ` +
      `mark.${reveal < 1 ? " The mark slides along it." : " The mark has been at seven places on it."}`;
  }

  /** @param {Stage} _ @param {Mark} mark */
  place(_, mark) {
    const {x, y, scale} = this.outside.window, {unit} = this.outside;
    return /** @type {[number, number]} */ ([(mark[0] / OUTSIDE.unit - x) * scale * unit,
      (mark[1] / OUTSIDE.unit - y) * scale * unit]);
  }

  /** @param {Stage} _ @param {[number, number]} at */
  unplace(_, at) {
    const [x, y] = this.outside.unplace(null, at);
    return outsideMark(x, y);
  }
}

/** @param {Camera} camera @param {number} depth m */
const onAxis = ({centre, rotation: R}, depth) => centre.map((v, i) => v + depth * R[3 * i + 2]);

