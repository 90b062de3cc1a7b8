/** What several figures do with the four images: a moment to draw, a hand that is dragged, marks over a drawing.
 * @import {World} from "../engine/world.js" @import {Images} from "../view/images.js" */
import {DEGREE, Session} from "../engine/engine.js";
import {dots, polyline} from "../lessons/figures/drawing.js";
import {add, px, set} from "../view/svg.js";

/** The pose of the demonstrator and the start of the learner in figures, rad. */
export const DEMONSTRATOR = [45 * DEGREE, -90 * DEGREE], START = [25 * DEGREE, -45 * DEGREE];

/** A session of the paper's transfer, for its snapshots.
 * @param {World} world @param {number[]} demonstrator @param {number[]} start @param {string} [servo] */
export const sessionOf = (world, demonstrator, start, servo = "broyden") =>
  new Session(world, {transfer: "epipolar", servo, demonstrator, start});

/** Paths over one image, in its px. */
export class Overlay {
  /** @param {Images} images @param {number} view @param {string[]} kinds classes of the paths, the lowest first */
  constructor(images, view, kinds) {
    this.images = images;
    this.view = view;
    this.paths = Object.fromEntries(kinds.map(kind => [kind, add(images.view(view).svg, "path", {class: kind})]));
  }

  /** @param {string} kind @param {ArrayLike<number>[]} points px of the image
   * @param {(points: number[][]) => string} mark */
  marks(kind, points, mark = dots) {
    set(this.paths[kind], {d: mark(points.map(p => this.images.place(this.view, p[0], p[1])))});
  }

  /** @param {string} kind @param {[ArrayLike<number>, ArrayLike<number>][]} pairs px of the image, from and to */
  spans(kind, pairs) {
    set(this.paths[kind], {d: pairs.map(ends => polyline(ends.map(p => this.images.place(this.view, p[0], p[1])))).join("")});
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
}

/** The x, y of a point in one view.
 * @param {ArrayLike<number>} images (4 N) px @param {number} point @param {number} view */
export const imageOf = (images, point, view) => [0, 1].map(k => images[4 * point + 2 * (view & 1) + k]);
