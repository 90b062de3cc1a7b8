/** What several figures do with the four images: a moment to draw, a hand that is dragged, marks over a drawing.
 * @import {World} from "../engine/world.js" @import {Images} from "../view/images.js" */
import {DEGREE, Session} from "../engine/engine.js";
import {dots, polyline} from "../lessons/figures/drawing.js";
import {add, set} from "../view/svg.js";

/** The pose of the demonstrator and the start of the learner in figures, rad. */
export const DEMONSTRATOR = [45 * DEGREE, -90 * DEGREE];
export const START = [25 * DEGREE, -45 * DEGREE];

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
}

/** The x, y of a point in one view.
 * @param {ArrayLike<number>} images (4 N) px @param {number} point @param {number} view */
export const imageOf = (images, point, view) => [0, 1].map(k => images[4 * point + 2 * (view & 1) + k]);
