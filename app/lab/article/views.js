/** What several figures do with the four images: a moment to draw, a hand that is dragged, marks over a drawing. */
import {clamp, projectPoint, reachFor, Session} from "../engine/engine.js";
import {add, px, set} from "../view/svg.js";
import {DEGREE} from "./frame.js";

/** @import {World} from "../engine/world.js"
 * @import {Images} from "../view/images.js" */

/** A session of the paper's transfer, for its snapshots.
 * @param {World} world @param {number[]} demonstrator @param {number[]} start @param {string} [servo] */
export const sessionOf = (world, demonstrator, start, servo = "broyden") =>
  new Session(world, {transfer: "epipolar", servo, demonstrator, start});

/** Follow a body point of an arm under a pointer: the posture within the limits that brings the point there.
 * @param {World} world @param {Images} images @param {number} view 0 … 3 @param {number} point
 * @param {PointerEvent} event where it is gripped @param {() => number[]} posture of the arm
 * @param {(theta: number[]) => void} moved @returns {(event: PointerEvent) => void} */
export function pulled(world, images, view, point, event, posture, moved) {
  const who = view < 2 ? "demonstrator" : "learner", camera = world.scene.cameras[view], body = [world.body[point]];
  const seen = (/** @type {number[]} */ theta) => projectPoint(camera, world.arms[who].points(theta, body)).slice(0, 2);
  const grip = images.under(event, view).map((v, k) => v - seen(posture())[k]), {lower, upper} = world.scene;
  return next => moved(reachFor(seen, images.under(next, view).map((v, k) => v - grip[k]), posture(), lower, upper));
}

/** The moving point of an arm that is nearest to a pointer.
 * @param {World} world @param {Images} images @param {number} view @param {PointerEvent} event
 * @param {Float64Array} seen (4 N) px */
export function nearest(world, images, view, event, seen) {
  const [x, y] = images.under(event, view), side = 2 * (view & 1);
  const away = world.body.map(({on}, i) =>
    on ? Math.hypot(seen[4 * i + side] - x, seen[4 * i + side + 1] - y) : Infinity);
  return away.indexOf(Math.min(...away));
}

/** Paths over one image, in its px. */
export class Overlay {
  /** @param {Images} images @param {number} view @param {string[]} kinds classes of the paths, the lowest first */
  constructor(images, view, kinds) {
    this.images = images;
    this.view = view;
    this.paths = Object.fromEntries(kinds.map(kind => [kind, add(images.view(view).svg, "path", {class: kind})]));
  }

  /** @param {string} kind @param {ArrayLike<number>[]} points px of the image
   * @param {(x: string, y: string) => string} mark */
  marks(kind, points, mark = dot) {
    set(this.paths[kind], {d: points.map(p => mark(...this.#at(p))).join("")});
  }

  /** @param {string} kind @param {[ArrayLike<number>, ArrayLike<number>][]} pairs px of the image, from and to */
  spans(kind, pairs) {
    set(this.paths[kind], {d: pairs.map(([a, b]) => `M${this.#at(a).join(" ")}L${this.#at(b).join(" ")}`).join("")});
  }

  /** An ellipse.
   * @param {string} kind @param {ArrayLike<number>} centre @param {number[]} halfAxes px
   * @param {number} angle rad, of the first */
  ellipse(kind, centre, [a, b], angle) {
    const {scale} = this.images.view(this.view).window, [x, y] = this.images.place(this.view, centre[0], centre[1]);
    const [u, v] = [a * scale * Math.cos(angle), a * scale * Math.sin(angle)], turn = angle * 180 / Math.PI;
    const arc = `A${px(a * scale)} ${px(Math.max(b * scale, .3))} ${turn.toFixed(2)} 1 0`;
    const [first, other] = [`${px(x - u)} ${px(y - v)}`, `${px(x + u)} ${px(y + v)}`];
    set(this.paths[kind], {d: `M${first}${arc} ${other}${arc} ${first}`});
  }

  /** @param {ArrayLike<number>} p @returns {[string, string]} */
  #at(p) {
    const [x, y] = this.images.place(this.view, p[0], p[1]);
    return [px(x), px(y)];
  }
}

/** @param {string} x @param {string} y */
export const dot = (x, y) => `M${x} ${y}h0`;
/** @param {string} x @param {string} y */
export const ring = (x, y) => `M${Number(x) - 8} ${y}a8 8 0 1 0 16 0a8 8 0 1 0 -16 0`;
/** @param {string} x @param {string} y */
export const diamond = (x, y) => `M${Number(x) - 4} ${y}l4 -4 4 4 -4 4z`;

/** What arrow keys make of a posture: up turns the first joint, right the second one.
 * @param {number[]} theta @param {number} right degrees @param {number} up degrees
 * @param {{lower: number[], upper: number[]}} limits */
export const turned = (theta, right, up, {lower, upper}) =>
  theta.map((v, k) => clamp(v + (k ? right : up) * DEGREE, lower[k], upper[k]));

/** The x, y of a point in one view.
 * @param {ArrayLike<number>} images (4 N) px @param {number} point @param {number} view */
export const imageOf = (images, point, view) => [0, 1].map(k => images[4 * point + 2 * (view & 1) + k]);
