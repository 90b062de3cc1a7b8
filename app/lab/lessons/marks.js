/** Marks in the figure that is asked about: the visitor's own, those of a class, and how far from the truth.
 * @import {Stage, Mark, Figure} from "./stage.js" */
import {draggable} from "../view/drag.js";
import {add, drawingUnit, px} from "../view/svg.js";
import {judged, measure} from "./measures.js";
import {distance, nearest} from "./measured.js";

const MOVED = 1e-6; // px or rad between a truth as it was judged and as it is now
const STEP_PX = 3, FAR_PX = 15, PILL_PX = 8.2, NARROW_PX = 400; // that arrow keys move a mark; width of a letter; a drawing whose number is in the card alone
const KEYS = /** @type {Record<string, [number, number]>} */ ({ArrowUp: [0, -1], ArrowDown: [0, 1],
  ArrowLeft: [-1, 0], ArrowRight: [1, 0]});

export class Marks {
  /** @param {HTMLElement} box of the figure @param {Figure} figure @param {() => Stage} stage
   * @param {(mark: Mark) => void} marked @param {() => boolean} isOpen whether a mark may be made */
  constructor(box, figure, stage, marked, isOpen) {
    this.box = box;
    this.figure = figure;
    this.stage = stage;
    this.marked = marked;
    this.isOpen = isOpen;
    this.svg = add(box, "svg", {class: "vi marks", "aria-hidden": "true"});
    this.last = "";
    box.tabIndex = 0;
    draggable(box, event => {
      if (!isOpen()) return null;
      box.focus(/** @type {any} */ ({preventScroll: true, focusVisible: false}));
      this.#at(event);
      return moved => { if (isOpen()) this.#at(moved); };
    }, () => {});
  }

  /** Arrow keys move the mark. @param {KeyboardEvent} event @returns {boolean} whether it is taken */
  key(event) {
    const way = KEYS[event.key];
    if (!way || !this.isOpen()) return false;
    const {mark} = this.stage(), {clientWidth, clientHeight} = this.box, by = event.shiftKey ? FAR_PX : STEP_PX;
    const from = mark && this.figure.place?.(this.stage(), mark) || [clientWidth / 2, clientHeight / 2];
    this.#mark([from[0] + way[0] * by, from[1] + way[1] * by]);
    return true;
  }

  /** @param {PointerEvent} event */
  #at(event) {
    const box = this.box.getBoundingClientRect();
    this.#mark([event.clientX - box.left, event.clientY - box.top]);
  }

  /** @param {[number, number]} at */
  #mark([x, y]) {
    const {clientWidth, clientHeight} = this.box;
    const mark = this.figure.unplace?.(this.stage(), [Math.min(clientWidth, Math.max(0, x)),
      Math.min(clientHeight, Math.max(0, y))]);
    if (mark) this.marked(mark);
  }

  draw() {
    const stage = this.stage(), {ask} = stage.step, unit = drawingUnit(), clientWidth = this.box.clientWidth / unit,
      clientHeight = this.box.clientHeight / unit;
    const at = (/** @type {Mark} */ mark) => {
      const found = this.figure.place?.(stage, mark);
      return found ? /** @type {[number, number]} */ ([found[0] / unit, found[1] / unit]) : null;
    };
    const own = stage.mark && at(stage.mark), round = stage.rounds[stage.rounds.length - 1];
    let html = stage.others.map(at).filter(found => found !== null)
      .map(([x, y]) => `<path class="mark-other" d="M${px(x - 4)} ${px(y - 4)}l8 8m0-8l-8 8"/>`).join("");
    const truth = ask.kind === "place" && stage.isRevealed && own && stage.mark && ask.truth
      ? measure(stage, ask.truth).value : null;
    const isMoved = truth && stage.mark && ask.truth
      && distance(nearest(stage.mark, truth), judged(stage, ask.truth).value) > MOVED; // by a slider, after the answer
    const between = truth && !isMoved ? /** @type {const} */ ([own,
      at(nearest(/** @type {Mark} */ (stage.mark), truth)),
      judged(stage, stage.step.headline?.measure ?? "distance in px").text])
      : ask.kind === "predict" && round && !stage.mark ? /** @type {const} */ ([at(round.mark), at(round.to),
        `${Math.hypot(round.mark[0] - round.to[0], round.mark[1] - round.to[1]).toFixed(1)} px`]) : null;
    if (between && between[0] && between[1] && (ask.kind === "predict" || clientWidth > NARROW_PX)) {
      const [[a, b], [c, d],
        text] = /** @type {[[number, number], [number, number], string]} */ (/** @type {unknown} */ (between)),
        wide = PILL_PX * text.length + 14;
      const length = Math.hypot(c - a, d - b), x = Math.min(clientWidth - wide / 2 - 4,
        Math.max(wide / 2 + 4, (a + c) / 2 + (length < 70 ? wide / 2 + 18 : 0)));
      const y = Math.min(clientHeight - 16, Math.max(16, (b + d) / 2 + (length < 70 ? (d < b ? 26 : -26) : 0)));
      html += `<path class="mark-way" d="M${px(a)} ${px(b)}L${px(c)} ${px(d)}"/><rect class="pill" x="${px(x - wide / 2)}" y="${px(y - 13)}" width="${px(wide)}" height="26" rx="13"/><text class="pill-text vi-mid" x="${px(x)}" y="${px(y + 5)}">${text}</text>`;
    }
    const cross = own ?? (between ? between[0] : null);
    if (cross) {
      const [x, y] = cross, isLabelRight = x < 110 || between && between[1] && between[1][0] < x && x < clientWidth - 110;
      html += `<g class="mark-own"><circle cx="${px(x)}" cy="${px(y)}" r="11"/><path d="M${px(x - 17)} ${px(y)}h11m12 0h11M${px(x)} ${px(y - 17)}v11m0 12v11"/></g>
<text class="mark-name vi-halo${isLabelRight ? "" : " vi-end"}" x="${px(x + (isLabelRight ? 23 : -23))}" y="${px(y + 5)}">your mark</text>`;
    }
    const viewBox = `0 0 ${clientWidth} ${clientHeight}`;
    if (this.svg.getAttribute("viewBox") !== viewBox) this.svg.setAttribute("viewBox", viewBox);
    if (html !== this.last) this.svg.innerHTML = this.last = html;
  }
}
