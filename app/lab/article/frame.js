/** What every figure of the article is made of: panels with drawings, controls below them, and sentences with numbers.
 * @import {Scene} from "../engine/world.js" @import {EnergyMap} from "../view/map.js" @import {Camera} from "../engine/camera.js"
 * @typedef {Object} Data what all figures share
 * @property {Scene} scene
 * @property {Scene} turned the same with a demonstrator that is turned
 * @property {Record<string, number[][]>} hulls outermost vertices of links
 * @property {{value: number, cameras: Camera[]}[]} distances of `turned`, times the first one
 * @property {{value: number, cameras: Camera[]}[]} baselines of `scene`, cm
 * @typedef {{measure: () => void, draw: () => void, state: () => Record<string, number | number[] | string>}} Figure
 * measure: the sizes of the panels have changed, or the colours; state: what it shows, for its still
 * @typedef {(frame: Frame, data: Data) => Figure} FigureKind */
import {make, slider} from "../lessons/dom.js";
import {arrowKeys, draggable} from "../view/drag.js";
import {perFrame} from "../view/page.js";

let named = 0;

/** A box that keys reach. @param {HTMLElement} box @param {string} label what a screen reader says */
export function reachable(box, label) {
  for (const [name, value] of [["tabindex", "0"], ["role", "group"], ["aria-label", label]]) box.setAttribute(name, value);
  return box;
}

export class Frame {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    this.facts = make("p", {class: "facts", "aria-live": "polite"});
    this.panels = make("div", {class: "panels"}, this.facts);
    this.controls = make("div", {class: "controls"});
    this.hint = make("p", {class: "hint"});
    box.append(this.panels, this.controls, this.hint);
    this.maps = /** @type {EnergyMap[]} */ ([]); // maps, which are drawn on canvases
    this.figure = /** @type {Figure | null} */ (null);
    this.redraw = perFrame(() => this.figure?.draw()); // in the next frame
  }

  /** A box for a drawing, with words below it. @param {string} area its class @param {string} caption */
  panel(area, caption) {
    const box = make("div", {class: "box"});
    this.facts.before(make("div", {class: `panel ${area}`}, box, caption && make("p", {class: "below", html: caption})));
    return box;
  }

  /** A map of E needs a canvas below its drawing. @param {string} area @param {string} caption @param {string} label */
  mapPanel(area, caption, label) {
    const box = this.panel(`${area} map`, caption);
    box.innerHTML = '<canvas aria-hidden="true"></canvas><svg class="vi" aria-hidden="true"></svg>';
    return reachable(box, label);
  }

  /** @param {Object} what @param {string} what.label @param {number} what.low @param {number} what.high
   * @param {number} what.step @param {number} what.value @param {(value: number) => string} what.text
   * @param {(value: number) => void} what.moved @param {string} [what.kind] whose it is: its class */
  slider({label, low, high, step, value, text, moved, kind = ""}) {
    const output = make("b", {class: "value"});
    const {input, show: stand} = slider({label, low, high, step}, now => {
      show(now);
      moved(now);
      this.redraw();
    });
    this.controls.append(make("label", {class: `slide ${kind}`}, make("span", {class: "name"}, label), input, output));
    const show = (/** @type {number} */ shown) => {
      output.textContent = text(shown);
      stand(shown, text(shown));
    };
    show(value);
    return {show, input};
  }

  /** One of a few, side by side.
   * @param {string} label @param {Record<string, string>} options what they are called, by their value
   * @param {string} value @param {(value: string) => void} chosen */
  choice(label, options, value, chosen) {
    const name = `choice-${named++}`, rows = Object.entries(options).map(([key, title]) => make("label", {},
      make("input", {type: "radio", name, value: key, checked: key === value, onchange: () => {
        chosen(key);
        this.redraw();
      }}), make("span", {}, title)));
    this.controls.append(make("fieldset", {class: "choice"}, make("legend", {}, label), ...rows));
  }

  /** @param {string} label @param {boolean} value @param {(on: boolean) => void} changed */
  check(label, value, changed) {
    const input = make("input", {type: "checkbox", checked: value, onchange: () => {
      changed(input.checked);
      this.redraw();
    }});
    this.controls.append(make("label", {class: "check"}, input, make("span", {}, label)));
    return input;
  }

  /** @param {string} label @param {() => void} act */
  button(label, act) {
    const made = make("button", {type: "button", onclick: () => {
      act();
      this.redraw();
    }}, label);
    this.controls.append(made);
    return made;
  }

  /** What the drawings show. Numbers are in <b>. @param {string[]} sentences HTML, "" for none */
  say(...sentences) {
    const html = sentences.filter(Boolean).join(" ");
    if (this.facts.innerHTML !== html) this.facts.innerHTML = html;
  }

  /** @param {HTMLElement} panel @param {(event: PointerEvent) => ((event: PointerEvent) => void) | null} begin */
  drag(panel, begin) {
    draggable(panel, event => {
      const follow = begin(event);
      if (!follow) return null;
      this.redraw();
      return moved => {
        follow(moved);
        this.redraw();
      };
    }, held => this.box.classList.toggle("held", held));
  }

  /** Arrow keys on a panel, with Shift five times as far.
   * @param {HTMLElement} panel @param {(right: number, up: number) => void} turn */
  arrows(panel, turn) {
    arrowKeys(panel, (right, up) => {
      turn(right, up);
      this.redraw();
    });
  }

  measure() {
    this.figure?.measure();
    this.figure?.draw();
  }
}
