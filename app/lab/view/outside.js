/** Arms, cameras and rays as somebody beside them sees them, as SVG: a parallel projection, in which parallel rays stay
 * parallel and a place on a line is easy to drag.
 * @typedef {[number, number, number]} Vector m in the world
 * @typedef {{frames: ArrayLike<number>[], kind: string}} Body T_world_link of every link; kind: its class, as
 * vi-demo
 * @typedef {{camera: Camera, kind: string, name: string}} Eye
 * @typedef {{bodies: Body[], eyes: Eye[], lines?: [ArrayLike<number>, ArrayLike<number>, string][], dots?:
 * [ArrayLike<number>, string][], labels?: [ArrayLike<number>, string, string][]}} Seen bodies: the farthest first;
 * lines: from, to, class; dots: place, class; labels: place, text, class @import {Camera} from "../engine/camera.js" */
import {around} from "../lessons/figures/drawing.js";
import {backProject, dot, transform} from "../engine/engine.js";
import {Plane} from "../lessons/figures/plane.js";
import {outermost, silhouette} from "./images.js";
import {add, px, set} from "./svg.js";

const MARGIN_PX = 26;
const LENS_M = 0.16, LENS_SHARE = 0.42; // from a camera to its image plate, and how much of that is drawn

export class Outside extends Plane {
  /** @param {HTMLElement} box @param {Record<string, number[][]>} hulls outermost vertices of links */
  constructor(box, hulls) {
    super(box);
    this.hulls = outermost(hulls);
    this.plane = add(this.svg, "rect", {class: "vi-plane", x: .5, y: .5, rx: 5});
    this.inside = add(this.svg, "g");
    /** Axes of the drawing in the world: to the right, up, towards the spectator. */
    this.axes = [[1, 0, 0], [0, 0, 1], [0, -1, 0]];
    this.measure();
  }

  measure() {
    super.measure();
    if (this.plane) set(this.plane, {width: px(this.width - 1), height: px(this.height - 1)});
  }

  /** Look from a direction, so that all of some places are in sight.
   * @param {number} azimuth rad, from the world's x to where the spectator stands @param {number} elevation rad
   * @param {ArrayLike<number>[]} places */
  look(azimuth, elevation, places) {
    const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
    this.axes = [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
    this.aim(around(places.map(p => this.#flat(p))),
      {margin: [MARGIN_PX, MARGIN_PX, MARGIN_PX, MARGIN_PX], glide: false});
  }

  /** @param {ArrayLike<number>} point of the world */
  #flat(point) { return [dot(this.axes[0], point), -dot(this.axes[1], point)]; }

  /** Where a point of the world is drawn, in the drawing's units. @override @param {ArrayLike<number>} point */
  at(point) { return super.at(this.#flat(point)); }

  /** Where in the drawing a pointer is. @param {PointerEvent} event @returns {[number, number]} */
  under(event) {
    const box = this.svg.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width * this.width, (event.clientY - box.top) / box.height * this.height];
  }

  /** The point of a line that is drawn nearest to a place.
   * @param {[number, number]} place @param {ArrayLike<number>} from @param {ArrayLike<number>} to
   * @returns {number} 0 at `from`, 1 at `to` */
  share([x, y], from, to) {
    const [a, b] = this.at(from), [c, d] = this.at(to), u = c - a, v = d - b;
    return ((x - a) * u + (y - b) * v) / (u * u + v * v);
  }

  /** @param {Seen} seen @param {string} label what a screen reader says */
  draw({bodies, eyes, lines = [], dots = [], labels = []}, label) {
    const at = (/** @type {ArrayLike<number>} */ p) => this.at(p).map(px).join(" ");
    const html = [...bodies.map(body => this.#arm(body)), ...eyes.map(eye => this.#eye(eye)),
      ...lines.map(([a, b, kind]) => `<path class="${kind}" d="M${at(a)}L${at(b)}"/>`),
      ...dots.map(([p, kind]) => `<path class="${kind}" d="M${at(p)}h0"/>`),
      ...labels.map(([p, text, kind]) => {
        const [x, y] = this.at(p), isLeft = x > this.width * .7; // of its place
        const place = `x="${px(x + (isLeft ? -9 : 9))}" y="${px(y + 4)}"`;
        return `<text class="vi-halo ${kind}${isLeft ? " vi-end" : ""}" ${place}>${text}</text>`;
      })].join("");
    if (html !== this.last) this.inside.innerHTML = this.last = html;
    set(this.svg, {"aria-label": label});
  }

  /** The links of an arm, the farthest first. @param {Body} body */
  #arm({frames, kind}) {
    const links = this.hulls.map(({link, vertices}) => {
      const corners = vertices.map(v => transform(frames[link], v));
      const depth = corners.reduce((sum, p) => sum + dot(this.axes[2], p), 0) / corners.length;
      return {depth, d: `M${silhouette(corners.map(p => this.at(p))).map(p => p.map(px).join(" ")).join("L")}z`};
    }).sort((a, b) => a.depth - b.depth);
    const paths = links.map(({d}) => `<path class="vi-blank" d="${d}"/><path class="vi-hull" d="${d}"/>`);
    return `<g class="vi-solid ${kind}">${paths.join("")}</g>`;
  }

  /** A camera as a pyramid: its eye, and the plate on which its image lies. @param {Eye} eye */
  #eye({camera, kind, name}) {
    const {width, height, principal: [x, y]} = camera, [w, h] = [LENS_SHARE * width / 2, LENS_SHARE * height / 2];
    const corners = [[-w, -h], [w, -h], [w, h], [-w, h]].map(([a, b]) => backProject(camera, x + a, y + b, LENS_M));
    const at = (/** @type {ArrayLike<number>} */ p) => this.at(p).map(px).join(" "), eye = at(camera.centre);
    const [u, v] = this.at(camera.centre), edges = corners.map(p => `M${eye}L${at(p)}`).join("");
    const label = `<text class="vi-halo vi-name vi-mid" x="${px(u)}" y="${px(v - 9)}">${name}</text>`;
    return `<g class="${kind}"><path class="vi-plate" d="M${corners.map(at).join("L")}z"/>
<path class="vi-frustum" d="${edges}"/><path class="vi-pupil" d="M${eye}h0"/></g>${label}`;
  }
}
