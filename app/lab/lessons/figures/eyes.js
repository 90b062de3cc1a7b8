/** Pictures 1 and 2 of the two cameras at one arm: a mark and the line that its slide along a ray draws, or three
 * marks, the lines of their rays, and the epipole in which these meet.
 * @import {Stage, FigureKind} from "../stage.js" @import {Camera} from "../../engine/camera.js" */
import {projectPoint} from "../../engine/camera.js";
import {outermost, silhouettes} from "../../view/images.js";
import {px} from "../../view/svg.js";
import {camerasOf, epipole, MARKS, markOf, marksOf, onRay, PLACES, rayLine, sliding, through} from "../rays.js";
import {Names} from "./names.js";
import {around, arrows, circles, clipped, polyline} from "./drawing.js";
import {isStill, Plane} from "./plane.js";

const MARGIN = /** @type {[number, number, number, number]} */ ([24, 40, 24, 36]); // drawing units, that stay free
const STICK_PX = 60; // of a stick that the window of picture 1 holds
const HOLDS_PX = 340, LEAST_PX = 90; // from the arm: an epipole that near is in the window; px that are kept when it is far
const EASE = 0.35; // of the reveal in which the window has opened

/** @param {1 | 2} number @returns {FigureKind} */
export const eye = number => ({
  layers: ["chosen", "framed", "dots", "epipolar line", "three marks", "three lines", "epipole"],
  title: `**${number}** camera ${number}`,
  aspect: 1,
  create: (box, stage) => new Picture(number, box, stage),
});

class Picture extends Plane {
  /** @param {1 | 2} number @param {HTMLElement} box @param {Stage} stage */
  constructor(number, box, stage) {
    super(box, "vi-demo");
    this.number = number;
    this.hulls = outermost(stage.page.hulls);
  }

  /** @param {Stage} stage @param {Set<string>} layers */
  draw(stage, layers) {
    const cameras = camerasOf(stage), camera = cameras[this.number - 1];
    const see = (/** @type {ArrayLike<number>} */ p) => projectPoint(camera, p);
    this.box.classList.toggle("framed", layers.has("framed"));
    const names = new Names([0, 0, this.width, this.height]);
    names.keepBox([0, 0, 90, 26]); // the figure's title
    const moves = layers.has("three marks") ? this.#arm(stage, layers, cameras, see, names)
      : this.#stick(stage, layers, cameras, see, names);
    if (moves) this.again(() => this.draw(stage, layers));
  }

  /** A mark on a stick, and where its slide takes it.
   * @param {Stage} stage @param {Set<string>} layers @param {Camera[]} cameras
   * @param {(p: ArrayLike<number>) => [number, number, number]} see @param {Names} names */
  #stick({world, reveal}, layers, cameras, see, names) {
    const mark = markOf(world), slide = sliding(reveal), first = cameras[0];
    const now = reveal > 0 ? onRay(first, mark, slide.share) : mark, [x, y] = see(mark);
    const spread = this.number === 1 ? [] : PLACES.map(share => see(onRay(first, mark, share)));
    const [left, , right] = around([...spread, [x - STICK_PX, y], [x + STICK_PX, y]]);
    this.aim([left, y - STICK_PX, right, y + STICK_PX], {margin: MARGIN, glide: false});
    const at = (/** @type {ArrayLike<number>} */ p) => this.at(see(p));
    let html = "";
    if (layers.has("epipolar line") && reveal > 0 && slide.reached > PLACES[0]) {
      const whole = this.ends(rayLine(cameras[1], first, mark));
      const part = reveal < 1 ? [at(onRay(first, mark, PLACES[0])), at(onRay(first, mark, slide.reached))] : whole;
      html += `<path class="draw-line" d="${polyline(part)}"/>`;
      if (part.length) names.keepLine(part, 4);
    }
    if (layers.has("dots")) for (const share of PLACES.filter(slide.passed)) {
      const p = at(onRay(first, mark, share));
      html += `<path class="draw-place" d="${circles([p], 4.5)}"/>`;
      names.keep(p, 6);
    }
    if (layers.has("chosen")) {
      const p = at(now), foot = at([now[0], now[1], 0]);
      html += `<path class="draw-stick" d="M${px(foot[0])} ${px(foot[1])}L${px(p[0])} ${px(p[1])}"/>` +
        `<path class="draw-mark-dot" d="${circles([p], 6.5)}"/>`;
      names.keep(p, 8);
      names.keepLine([p, foot], 4);
    }
    if (reveal > 0 && this.number === 1) names.put("does not move", at(now), "vi-chosen", {away: 13, first: [1, -1]});
    if (reveal === 1 && this.number === 2) names.put("epipolar line", at(onRay(first, mark, PLACES[5])), "vi-chosen",
      {away: 11, first: [1, 1]});
    this.show(html + names.html,
      this.number === 1 ? `Picture 1: the mark on its stick.${reveal > 0 ? " It does not move." : ""}`
      : `Picture 2: the mark on its ` +
        `stick.${reveal > 0 ? " As it slides along the ray, it draws a straight line, the epipolar line." : ""}`);
    return false;
  }

  /** An arm with three marks, the lines of their rays, and where these meet.
   * @param {Stage} stage @param {Set<string>} layers @param {Camera[]} cameras
   * @param {(p: ArrayLike<number>) => [number, number, number]} see @param {Names} names */
  #arm(stage, layers, cameras, see, names) {
    const frames = stage.world.arms.demonstrator.linkFrames(stage.moment.thetaDemo);
    const hulls = silhouettes(this.hulls, frames, see);
    const body = around(hulls.flat()), middle = [(body[0] + body[2]) / 2, (body[1] + body[3]) / 2];
    const e = epipole(cameras[1], cameras[0]), away = [e[0] - middle[0], e[1] - middle[1]], far = Math.hypot(...away);
    const opened = layers.has("epipole") ? Math.min(1, stage.reveal / EASE) : 0;
    const held = opened * (far < HOLDS_PX ? far : Math.max(LEAST_PX, HOLDS_PX - (far - HOLDS_PX) / 2)) / far;
    const reach = [middle[0] + held * away[0], middle[1] + held * away[1]];
    const margin = /** @type {[number, number, number, number]} */ ([30, 44, far < HOLDS_PX && opened ? 40 : 30, 36]);
    const moves = this.aim(around([[body[0], body[1]], [body[2], body[3]], reach]), {margin, glide: !isStill()});
    const marks = marksOf(stage), lines = marks.map(p => rayLine(cameras[1], cameras[0], p));
    const hull = hulls.map(points => this.path(points, true)).join("");
    const bone = this.path(frames.map(T => see([T[3], T[7], T[11]])));
    let html = `<path class="vi-hull" d="${hull}"/><path class="vi-bone" d="${bone}"/>`;
    const at = marks.map(p => this.at(see(p))), hole = this.at(e);
    at.forEach(p => names.keep(p, 8));
    if (layers.has("three lines")) {
      const grown = layers.has("epipole") ? Math.min(1, stage.reveal / .6) : 1;
      lines.forEach((line, k) => {
        const ends = grown < 1 ? towards(at[k], hole, grown, this) : this.ends(line);
        if (!ends.length) return;
        html += `<path class="draw-line" d="${polyline(ends)}"/>`;
        names.keepLine(ends);
      });
    }
    at.forEach(p => { html += `<path class="draw-mark-dot" d="${circles([p], 6.5)}"/>`; });
    if (layers.has("epipole") && opened === 1) {
      const isIn = hole[0] > 12 && hole[0] < this.width - 12 && hole[1] > 12 && hole[1] < this.height - 12;
      if (isIn) {
        html += `<path class="draw-hole" d="${circles([hole], 8)}"/>`;
        names.keep(hole, 10);
        names.put(this.width < 340 ? "epipole" : "epipole: camera 1, as camera 2 sees it", hole, "vi-chosen",
          {away: 13});
      } else html += this.#beyond(e, middle, far, names);
    }
    at.forEach((p, k) => names.put(MARKS[k], p, "vi-chosen", {away: 8, size: 14}));
    this.show(html + names.html, layers.has("three lines")
      ? `Picture 2: an arm with three marks. The lines of their rays meet in the epipole, ${Math.round(far)} px from ` +
        `the arm.`
      : "Picture 2: an arm with three marks.");
    return moves;
  }

  /** An arrow to an epipole that the window does not hold.
   * @param {ArrayLike<number>} e @param {number[]} middle @param {number} far px @param {Names} names */
  #beyond(e, middle, far, names) {
    const from = this.at(middle), line = through(middle, e), ends = this.ends(line);
    if (!ends.length) return "";
    const to = this.at(e), isAhead = (/** @type {number[]} */ p) => (p[0] - from[0]) * (to[0] - from[0])
      + (p[1] - from[1]) * (to[1] - from[1]) > 0;
    const edge = ends.find(isAhead) ?? ends[1];
    const u = [edge[0] - from[0], edge[1] - from[1]].map((v, _, all) => v / Math.hypot(...all));
    const tip = [edge[0] - 8 * u[0], edge[1] - 8 * u[1]], tail = [tip[0] - 34 * u[0], tip[1] - 34 * u[1]];
    names.keepLine([tail, tip], 6);
    names.put(`epipole, ${Math.round(far)} px that way`, tail, "vi-chosen", {away: 10});
    return arrows([[tail, tip]], 9, "draw-beyond", "draw-beyond-tip");
  }
}

/** A line that grows from a mark both ways, first to the epipole.
 * @param {[number, number]} from @param {ArrayLike<number>} to @param {number} share @param {Plane} plane */
function towards(from, to, share, plane) {
  const d = [to[0] - from[0], to[1] - from[1]];
  const ends = [-share, share].map(s => [from[0] + s * d[0], from[1] + s * d[1]]);
  return clipped(ends[0], ends[1], [0, 0, plane.width, plane.height]);
}
