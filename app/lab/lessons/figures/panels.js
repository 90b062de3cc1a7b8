/** Small maps of E beside each other, each with its title and what it comes to.
 * @import {Landscape} from "../../engine/landscape.js" @import {Scene} from "../stage.js"
 * @typedef {Object} MapOfE
 * @property {string} title
 * @property {string} words what it comes to; empty for nothing
 * @property {{landscape: Landscape, key: string} | null} map null for a plane without relief
 * @property {string} [instead] large words on a plane without relief
 * @property {number[] | null} demonstrator rad
 * @property {number[][]} lowest rad, the smallest E first
 * @property {boolean} [gap] whether a line leads from the smallest E to the demonstrator */
import {EnergyMap} from "../../view/map.js";
import {make} from "../dom.js";
import {crosses, diamonds, path, polyline, text} from "./drawing.js";
import {Names} from "./names.js";

export class MapPanel {
  /** @param {HTMLElement} within */
  constructor(within) {
    this.title = make("b");
    this.words = make("span");
    const box = make("div", {class: "lesson-map"});
    this.box = within.appendChild(make("div", {class: "lesson-panel"},
      make("div", {class: "lesson-panel-head"}, this.title, this.words), box));
    this.map = new EnergyMap(box);
    this.ground = "";
  }

  resize() { this.ground = ""; }

  /** @param {MapOfE} what @param {Scene} scene */
  draw({title, words, map: made, instead = "", demonstrator, lowest, gap = false}, {lower, upper, names: joints}) {
    const {map} = this, key = `${made?.key} ${document.documentElement.dataset.scheme}`;
    this.title.textContent = title;
    this.words.textContent = words;
    if (key !== this.ground) map.ground(made?.landscape ?? null, {lower, upper, joints});
    this.ground = key;
    const [left, top, right, bottom] = map.plot, names = new Names(map.plot);
    const at = lowest.map(theta => map.place(theta)), demo = demonstrator && map.place(demonstrator);
    for (const each of [...at, ...demo ? [demo] : []]) names.keep(each, 8);
    let over = gap && demo && at.length ? path("lesson-gap", polyline([at[0], demo])) : "";
    if (gap && demo && at.length) names.keepLine([at[0], demo]);
    const cross = crosses(at.slice(1), 3.5) + crosses(at.slice(0, 1), 7.5);
    over += path("lesson-cross-case", cross) + path("vi-cross", cross);
    if (demo) over += path("vi-seen", diamonds([demo], 5.5));
    if (gap && demo) names.put("demonstrator", demo, "vi-of-demo", {first: [1, 0], lead: "vi-lead-demo"});
    if (gap && at.length) names.put("smallest E", at[0], "", {first: [-1, 0]});
    const size = instead.length > 1 ? "lesson-large" : "lesson-huge";
    const middle = (top + bottom) / 2 + (instead.length > 1 ? 6 : 17);
    if (instead) over += text((left + right) / 2, middle, instead, `${size} vi-b vi-mid`);
    map.moving.innerHTML = over + names.html;
    map.clear(box => names.isFree(box));
    map.over.setAttribute("aria-label", `Map of E, ${title}: ${instead || words || "hidden"}`);
  }
}
