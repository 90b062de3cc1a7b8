/** The landscape of E: shading and contours on a canvas, marks over it as SVG.
 * @typedef {Pick<import("../engine/landscape.js").Landscape, "axes" | "count" | "E" | "minimum" | "posture">} Ground */
import {clamp, DEGREE} from "../engine/engine.js";
import {add, diamonds, drawingUnit, escaped, px, set} from "./svg.js";

/** @typedef {{clientX: number, clientY: number}} Pointer */

const LEVELS = [0.01, 0.1, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000]; // px²
const MAX_LEVELS = 7, RANGE = 2000, BRIGHTEST = 1000, DARKEST = 0.01; // E is shaded over this factor, up to these px²
const NAME_PX = 7.2, NUMBER_PX = [10, 7]; // of a letter; half width and height of a contour's number
const NEAR_PX = 12, RING_PX = 11; // of the learner from other marks
const TICK_PX = 36; // from one angle to the next
const PAD = {left: 52, top: 8, right: 12, bottom: 35};

/** Marching squares: where a grid of values crosses a level, in grid units.
 * @param {Float64Array} z row by row @param {number} rows @param {number} columns @param {number} level
 * @param {(x0: number, y0: number, x1: number, y1: number) => void} line */
export function contour(z, rows, columns, level, line) {
  for (let i = 0; i < rows - 1; i++) for (let j = 0; j < columns - 1; j++) {
    const at = i * columns + j, a = z[at] - level, b = z[at + 1] - level, c = z[at + columns + 1] - level, d = z[at + columns] - level;
    const key = +(a > 0) | +(b > 0) << 1 | +(c > 0) << 2 | +(d > 0) << 3;
    if (key === 0 || key === 15) continue;
    const top = [j + a / (a - b), i], right = [j + 1, i + b / (b - c)], bottom = [j + d / (d - c), i + 1], left = [j, i + a / (a - d)];
    const cut = (/** @type {number[]} */ p, /** @type {number[]} */ q) => line(p[0], p[1], q[0], q[1]);
    if (key === 1 || key === 14) cut(left, top);
    else if (key === 2 || key === 13) cut(top, right);
    else if (key === 3 || key === 12) cut(left, right);
    else if (key === 4 || key === 11) cut(right, bottom);
    else if (key === 6 || key === 9) cut(top, bottom);
    else if (key === 7 || key === 8) cut(left, bottom);
    else if (key === 5) { cut(left, top); cut(right, bottom); }
    else { cut(top, right); cut(left, bottom); }
  }
}

export class EnergyMap {
  /** @param {HTMLElement} box */
  constructor(box) {
    this.box = box;
    this.canvas = box.querySelector("canvas") ?? box.appendChild(document.createElement("canvas"));
    this.over = box.querySelector("svg") ?? add(box, "svg", {class: "vi lesson-drawing", role: "img"});
    this.image = document.createElement("canvas");
    /** @type {{lower: number[], upper: number[], joints: string[]}} */
    this.range = {lower: [0, 0], upper: [1, 1], joints: ["", ""]};
    // Axes, the path, the contours' numbers over it, and above all the dots with their names
    this.standing = add(this.over, "g");
    this.way = add(this.over, "g");
    this.levels = add(this.over, "g");
    this.moving = add(this.over, "g");
    this.written = /** @type {Map<SVGGElement, string>} */ (new Map()); // what each of them shows
    this.numbers = /** @type {number[][]} */ ([]); // places of the contours' numbers
    this.z = new Float64Array(0);
    /** The drawing below the marks: its grid, and the contours' levels, ln px².
     * @type {{rows: number, columns: number, levels: number[]}} */
    this.drawn = {rows: 0, columns: 0, levels: []};
    this.unit = 1; // px of a drawing's unit
    this.width = 1;
    this.height = 1;
  }

  /** Where a posture is drawn, px. @param {number[]} theta */
  place([first, second]) {
    const {lower, upper} = this.range;
    return [
      PAD.left + (second - lower[1]) / (upper[1] - lower[1]) * (this.width - PAD.left - PAD.right),
      PAD.top + (upper[0] - first) / (upper[0] - lower[0]) * (this.height - PAD.top - PAD.bottom),
    ];
  }

  /** The posture at a place, within the limits. @param {number} x @param {number} y */
  posture(x, y) {
    const {lower, upper} = this.range;
    return [
      clamp(upper[0] - (y - PAD.top) / (this.height - PAD.top - PAD.bottom) * (upper[0] - lower[0]), lower[0], upper[0]),
      clamp(lower[1] + (x - PAD.left) / (this.width - PAD.left - PAD.right) * (upper[1] - lower[1]), lower[1], upper[1]),
    ];
  }

  /** The plot's left, top, right and bottom, px. @returns {[number, number, number, number]} */
  get plot() { return [PAD.left, PAD.top, this.width - PAD.right, this.height - PAD.bottom]; }

  /** The place under a pointer, in the drawing's units. @param {Pointer} pointer @param {DOMRect} [box] if it is known */
  under({clientX, clientY}, {left, top} = this.box.getBoundingClientRect()) {
    return [(clientX - left) / this.unit, (clientY - top) / this.unit];
  }

  /** The posture under a pointer, within the limits. @param {Pointer} pointer @param {DOMRect} [box] */
  postureAt(pointer, box) {
    const [x, y] = this.under(pointer, box);
    return this.posture(x, y);
  }

  /** Shade E, and draw its contours.
   * @param {Ground | null} landscape null for the axes alone
   * @param {{lower: number[], upper: number[], joints: string[]}} range */
  ground(landscape, range) {
    this.range = range;
    this.unit = drawingUnit();
    this.width = this.box.clientWidth / this.unit;
    this.height = this.box.clientHeight / this.unit;
    const {canvas, width, height} = this, ratio = this.unit * Math.min(3, devicePixelRatio || 1);
    if (width < PAD.left + PAD.right + 20 || height < PAD.top + PAD.bottom + 20) return;
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    set(this.over, {viewBox: `0 0 ${width} ${height}`});
    if (!landscape) {
      canvas.width = w; // clears it
      this.numbers = [];
      this.#write(this.levels, "");
      return this.#axes();
    }
    const rows = landscape.axes[0].length, columns = landscape.axes[1].length, {E} = landscape;
    if (this.z.length !== landscape.count) this.z = new Float64Array(landscape.count);
    const z = this.z;
    let most = -Infinity, least = Infinity;
    for (let g = 0; g < z.length; g++) {
      z[g] = Math.log(Math.max(E[g], 1e-9));
      if (z[g] > most) most = z[g];
      if (z[g] < least) least = z[g];
    }
    most = Math.max(Math.min(most, Math.log(BRIGHTEST)), Math.log(DARKEST));
    least = Math.min(Math.max(least, most - Math.log(RANGE)), most - .5);
    const style = getComputedStyle(this.box), role = (/** @type {string} */ name) => style.getPropertyValue(`--${name}`).trim();
    this.#shade(rows, columns, least, most, role("hills"));
    const brush = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const left = PAD.left, top = PAD.top, right = width - PAD.right, bottom = height - PAD.bottom;
    const stepX = (right - left) / (columns - 1), stepY = (bottom - top) / (rows - 1);
    brush.setTransform(ratio, 0, 0, ratio, 0, 0);
    brush.clearRect(0, 0, width, height);
    brush.save();
    brush.beginPath();
    brush.rect(left, top, right - left, bottom - top);
    brush.clip();
    brush.imageSmoothingQuality = "high";
    brush.drawImage(this.image, left - stepX / 2, top - stepY / 2, right - left + stepX, bottom - top + stepY);
    brush.strokeStyle = role("ink");
    brush.globalAlpha = .5;
    brush.lineWidth = .8;
    brush.lineJoin = brush.lineCap = "round";
    brush.beginPath();
    const middle = this.place(landscape.minimum?.theta ?? landscape.posture(0));
    const corners = [[left, top], [right, top], [left, bottom], [right, bottom]], away = (/** @type {number[]} */ p) => Math.hypot(p[0] - middle[0], p[1] - middle[1]);
    const far = corners.reduce((a, b) => away(b) > away(a) ? b : a), ray = Math.atan2(far[1] - middle[1], far[0] - middle[0]);
    const taken = /** @type {number[][]} */ ([]);
    let labels = "";
    const levels = LEVELS.filter(v => Math.log(v) > least && Math.log(v) < most).slice(-MAX_LEVELS);
    this.drawn = {rows, columns, levels: levels.map(Math.log)};
    for (const level of levels) {
      const best = [{off: Infinity, x: 0, y: 0}, {off: Infinity, x: 0, y: 0}]; // on the ray from the minimum, and behind it
      contour(z, rows, columns, Math.log(level), (x0, y0, x1, y1) => {
        const x = left + x0 * stepX, y = bottom - y0 * stepY, turn = Math.atan2(y - middle[1], x - middle[0]) - ray;
        brush.moveTo(x, y);
        brush.lineTo(left + x1 * stepX, bottom - y1 * stepY);
        const off = Math.abs(Math.atan2(Math.sin(turn), Math.cos(turn)));
        if (off < best[0].off) best[0] = {off, x, y};
        if (Math.PI - off < best[1].off) best[1] = {off: Math.PI - off, x, y};
      });
      for (const {off, x, y} of best) {
        const inside = x > left + 14 && x < right - 16 && y > top + 9 && y < bottom - 9;
        if (!(off < .2 && inside && away([x, y]) > 24 && taken.every(p => Math.hypot(p[0] - x, p[1] - y) > 28))) continue;
        taken.push([x, y]);
        labels += `<text class="vi-level vi-2nd vi-halo vi-mid" x="${px(x)}" y="${px(y + 4)}">${level}</text>`;
      }
    }
    brush.stroke();
    brush.restore();
    this.numbers = taken;
    this.#write(this.levels, labels);
    this.#axes();
  }

  /** Leave out the contours' numbers that something covers. @param {(box: [number, number, number, number]) => boolean} isFree */
  clear(isFree) {
    for (const level of this.levels.querySelectorAll(".vi-level")) {
      const x = Number(level.getAttribute("x")), y = Number(level.getAttribute("y"));
      level.classList.toggle("lesson-covered", !isFree([x - 13, y - 12, x + 13, y + 4]));
    }
  }

  /** @param {SVGGElement} group @param {string} html */
  #write(group, html) {
    if (html === this.written.get(group)) return;
    group.innerHTML = html;
    this.written.set(group, html);
  }

  #axes() {
    const {width, height, range: {lower, upper, joints}} = this, left = PAD.left, bottom = height - PAD.bottom;
    const room = [bottom - PAD.top, width - left - PAD.right];
    const ticks = (/** @type {number} */ k) => nice(lower[k], upper[k], Math.min(5, room[k] / TICK_PX)).map(degrees => {
      const [a, b] = this.place(k ? [lower[0], degrees * DEGREE] : [degrees * DEGREE, lower[1]]), text = `${String(degrees).replace("-", "−")}°`;
      const [kind, x] = a > width - 20 ? ["vi-end", width] : ["vi-mid", a]; // the last number stays within the drawing
      return k ? `<path class="vi-axis" d="M${px(a)} ${bottom}v4"/><text class="vi-2nd ${kind}" x="${px(x)}" y="${bottom + 17}">${text}</text>`
        : `<path class="vi-axis" d="M${left} ${px(b)}h-4"/><text class="vi-2nd vi-end" x="${left - 7}" y="${px(b + 4)}">${text}</text>`;
    }).join("");
    const html = `<rect class="vi-rule" x="${left}" y="${PAD.top}" width="${px(width - left - PAD.right)}" height="${px(bottom - PAD.top)}"/>${ticks(1)}${ticks(0)}
<text class="vi-2nd vi-mid vi-halo" x="${px((left + width - PAD.right) / 2)}" y="${bottom + 29}">${escaped(joints[1])}</text>
<text class="vi-2nd vi-mid vi-halo" transform="translate(12 ${px((PAD.top + bottom) / 2)}) rotate(-90)">${escaped(joints[0])}</text>`;
    this.#write(this.standing, html);
  }

  /** @param {number} rows @param {number} columns @param {number} least @param {number} most @param {string} hills */
  #shade(rows, columns, least, most, hills) {
    const {image, z} = this, rgb = [1, 3, 5].map(k => parseInt(hills.slice(k, k + 2), 16));
    [image.width, image.height] = [columns, rows];
    const brush = /** @type {CanvasRenderingContext2D} */ (image.getContext("2d")), pixels = brush.createImageData(columns, rows), {data} = pixels;
    for (let i = 0; i < rows; i++) for (let j = 0; j < columns; j++) {
      const t = clamp((z[i * columns + j] - least) / (most - least), 0, 1), at = 4 * ((rows - 1 - i) * columns + j);
      data[at] = rgb[0];
      data[at + 1] = rgb[1];
      data[at + 2] = rgb[2];
      data[at + 3] = 205 * t * (.25 + .75 * t);
    }
    brush.putImageData(pixels, 0, 0);
  }

  /** @param {Object} what @param {number[] | null} what.demonstrator null to leave it out
   * @param {number[]} what.learner @param {number[] | null} what.minimum
   * @param {{theta: number[], probe: boolean, isPast: boolean}[]} what.path postures visited; those past had another
   * E @param {number[][]} [what.later] postures still to come, of a recorded run
   * @param {number[][]} [what.demonstrators] postures where the demonstrator was before */
  marks({demonstrator, learner, minimum, path, later = [], demonstrators = []}) {
    const {width, height} = this, at = (/** @type {number[]} */ theta) => this.place(theta).map(px).join(" "), [x, y] = this.place(learner);
    const goal = demonstrator && this.place(demonstrator), dots = [[x, y], ...goal ? [goal] : []];
    /** Left, top, right, bottom of each name and number. */
    const taken = this.numbers.map(([a, b]) => [a - NUMBER_PX[0], b - NUMBER_PX[1], a + NUMBER_PX[0], b + NUMBER_PX[1]]);
    /** A name beside its dot, in the first of four places that is free. */
    const name = (/** @type {number[]} */ [a, b], /** @type {string} */ kind, /** @type {string} */ text) => {
      const wide = NAME_PX * text.length, boxes = [[1, -1], [-1, 1], [1, 1], [-1, -1]].map(([right, down]) => {
        const left = right > 0 ? a + 12 : a - 12 - wide, top = down > 0 ? b + 6 : b - 21;
        return [left, top, left + wide, top + 16];
      });
      const isFree = (/** @type {number[]} */ [left, top, right, bottom]) => left > PAD.left && right < width - PAD.right && top > PAD.top && bottom < height - PAD.bottom
        && taken.every(other => right < other[0] || left > other[2] || bottom < other[1] || top > other[3])
        && dots.every(([u, v]) => u + 8 < left || u - 8 > right || v + 8 < top || v - 8 > bottom);
      const box = boxes.find(isFree);
      if (!box) return "";
      taken.push(box);
      return `<text class="${kind} vi-halo vi-b" x="${px(box[0])}" y="${px(box[1] + 13)}">${text}</text>`;
    };
    const past = path.filter(({isPast}) => isPast), since = path.slice(past.length);
    const way = `M${[...since.map(({theta}) => theta), learner].map(at).join("L")}`;
    const line = (/** @type {string} */ kind, /** @type {number[][]} */ postures) =>
      postures.length > 1 ? `<path class="${kind}" d="M${postures.map(at).join("L")}"/>` : "";
    const still = (later.length ? line("vi-line-own vi-later", [learner, ...later]) : "")
      + (demonstrator ? line("vi-line-demo", [...demonstrators, demonstrator]) : "");
    const before = past.length ? `<path class="vi-line-own vi-later" d="M${[...past.map(({theta}) => theta), since[0]?.theta ?? learner].map(at).join("L")}"/>` : "";
    const visited = since.map(({theta, probe}) => {
      const [a, b] = this.place(theta);
      return probe ? `<circle class="vi-probe-own" cx="${px(a)}" cy="${px(b)}" r="3.2"/>` : `<path class="vi-dot-own" d="M${px(a)} ${px(b)}h0"/>`;
    }).join("");
    const cross = minimum && this.place(minimum), circle = (/** @type {string} */ kind, /** @type {number} */ r) =>
      `<circle class="${kind}" cx="${px(x)}" cy="${px(y)}" r="${r}"/>`;
    // A ring, where a dot would hide the map
    const isNear = [goal, cross].some(mark => mark && Math.hypot(x - mark[0], y - mark[1]) < NEAR_PX);
    const dot = isNear ? circle("vi-line-own vi-case", RING_PX) + circle("vi-line-own", RING_PX) : circle("vi-now", 7.5);
    const drawn = `<path class="vi-line-own vi-case" d="${way}"/><path class="vi-line-own" d="${way}"/>`;
    this.#write(this.way, `${still}${before}${drawn}${visited}`);
    const html = `${goal ? `<path class="vi-seen" d="${diamonds([goal], 6.5)}"/>` : ""}${cross ? `<path class="vi-cross" d="M${px(cross[0] - 7)} ${px(cross[1])}h14m-7-7v14"/>` : ""}${dot}
${goal ? name(goal, "vi-of-demo", "demonstrator") : ""}${goal && Math.hypot(x - goal[0], y - goal[1]) < 30 ? "" : name([x, y], "vi-of-own", "learner")}`;
    this.#write(this.moving, html);
  }
}

/** Round numbers of degrees between two angles, some five. @param {number} low rad @param {number} high rad
 * @param {number} most how many there is room for */
export function nice(low, high, most) {
  const [from, to] = [low / DEGREE - 1e-6, high / DEGREE + 1e-6], found = [];
  const step = [.1, .2, .5, 1, 2, 5, 10, 15, 30, 45, 90].find(each => (to - from) / each <= Math.min(6, most)) ?? 180;
  for (let k = Math.ceil(from / step); k * step <= to; k++) found.push(Math.round(k * step * 10) / 10);
  return found;
}
