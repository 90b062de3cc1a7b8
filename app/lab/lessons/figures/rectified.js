/** Eyes turned inwards: the map of E as they see and rectified by their matches, and the matches of both eyes, which
 * lie in equal rows then.
 * @import {Stage, FigureKind} from "../stage.js"
 * @typedef {{left: number[], right: number[]}} Rectification homographies of the left and the right eye, row by row */
import {conflict, farthest, Landscape, select, TRANSFERS} from "../../engine/engine.js";
import {fixed} from "../../view/svg.js";
import {lowestOf, MAP_DEG, mapOf, smallest} from "../maps.js";
import {once} from "../../view/once.js";
import {around, diamonds, path, polyline, rectangle, sketched, text, widthOf} from "./drawing.js";
import {MapPanel} from "./panels.js";

const LAYERS = ["as seen", "rectified"], TITLES = ["As the eyes see", "Rectified by matches alone"];
const MIN_DENOMINATOR = .1; // of a homography, as of the library's: no point is at infinity
const GAP = 18, LINE = 18, MARGIN = 14, LEAST_PX = .01;

/** @type {FigureKind} */
export const RECTIFIED = {
  layers: LAYERS,
  title: "Maps of E, as seen and rectified",
  aspect: 1.1,
  create(box) {
    box.classList.add("bare", "lesson-panels", "lesson-panels-column");
    const panels = LAYERS.map(() => new MapPanel(box));
    return {
      resize() {
        for (const panel of panels) panel.resize();
      },
      draw(stage, layers) {
        const demonstrator = stage.moment.thetaDemo;
        LAYERS.forEach((layer, k) => {
          panels[k].box.style.visibility = layers.has(layer) ? "" : "hidden";
          if (!layers.has(layer)) return;
          const {map, least} = layer === "rectified" ? mappedRectified(stage) : mappedAsSeen(stage);
          const words = least ? `${fixed(farthest(least, demonstrator))}° off` : "";
          const lowest = least ? [least] : [], {scene} = stage.world;
          const shown = stage.truthHidden ? {words: "", demonstrator: null} : {words, demonstrator};
          panels[k].draw({title: TITLES[k], ...shown, map, lowest, gap: true}, scene);
        });
      },
    };
  },
};

/** @type {FigureKind} */
export const ROWS = {
  layers: LAYERS,
  title: "Matches of both eyes",
  aspect: .62,
  create: sketched("lesson-rows", (drawing, stage, layers) => {
    const {views, usable} = stage.moment, images = select(views.demo, usable);
    const by = /** @type {Rectification} */ (stage.records.rectification), high = drawing.height / LAYERS.length;
    const cases = LAYERS.filter(layer => layers.has(layer)).map(layer =>
      ({layer, images: layer === "rectified" ? rectified(images, by) : images}));
    const words = cases.map(each => `${each.layer}, ${difference(each.images)}`).join("; ");
    return [cases.map((each, k) => rows(each, k * high, drawing.width, high - 8)).join(""),
      `Matches of the left and the right eye: ${words}.`];
  }),
};

/** @typedef {{map: {landscape: Landscape, key: string}, least: number[] | null}} Mapped least: rad */

/** E of the images as they are. @param {Stage} stage @returns {Mapped} */
export function mappedAsSeen({world, session: {settings: {transfer}}, moment}) {
  const demo = world.look("demonstrator", moment.thetaDemo);
  return {map: mapOf(world, transfer, demo), least: smallest(world, transfer, demo)};
}

/** E of a transfer between rectified images. It is measured in the images as they are.
 * @param {Stage} stage @returns {Mapped} */
export const mappedRectified = stage => once(stage.world, "rectified", () => rectifiedMap(stage));

/** @param {Stage} stage @returns {Mapped} */
function rectifiedMap({world, session: {settings: {transfer}}, moment, records}) {
  /** @type {Rectification} */
  const by = records.rectification, back = {left: inverse(by.left), right: inverse(by.right)};
  const demo = rectified(world.look("demonstrator", moment.thetaDemo).images, by);
  const energyAt = (/** @type {number[]} */ theta) => {
    const own = world.look("learner", theta).images, fitted = TRANSFERS[transfer].fit(demo, rectified(own, by));
    const seen = rectified(fitted.recover(demo), back);
    return conflict(own.map((v, i) => v - seen[i]));
  };
  const landscape = new Landscape(world, MAP_DEG);
  for (let g = 0; g < landscape.count; g++) landscape.E[g] = energyAt(landscape.posture(g));
  return {map: {landscape, key: "rectified"}, least: lowestOf(landscape, energyAt)};
}

/** Of a homography, up to its scale. @param {number[]} H row by row @returns {number[]} */
function inverse([a, b, c, d, e, f, g, h, i]) {
  const det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
  return [
    e * i - f * h, c * h - b * i, b * f - c * e,
    f * g - d * i, a * i - c * g, c * d - a * f,
    d * h - e * g, b * g - a * h, a * e - b * d,
  ].map(v => v / det);
}

/** @param {Float64Array} images (4 N) px @param {Rectification} by */
function rectified(images, {left, right}) {
  const found = new Float64Array(images.length);
  for (let k = 0; k < images.length; k += 2) {
    const H = k % 4 ? right : left, x = images[k], y = images[k + 1];
    const w = Math.max(H[6] * x + H[7] * y + H[8], MIN_DENOMINATOR);
    found[k] = (H[0] * x + H[1] * y + H[2]) / w;
    found[k + 1] = (H[3] * x + H[4] * y + H[5]) / w;
  }
  return found;
}

/** How far the rows of matches differ, in words. @param {Float64Array} images */
function difference(images) {
  let sum = 0;
  for (let i = 0; i < images.length; i += 4) sum += (images[i + 3] - images[i + 1]) ** 2;
  const off = Math.sqrt(sum * 4 / images.length);
  return `rows differ by ${off < LEAST_PX ? `less than ${LEAST_PX}` : fixed(off, 2)} px`;
}

/** Both images beside each other, equally large and at one height.
 * @param {{layer: string, images: Float64Array}} what @param {number} top @param {number} width
 * @param {number} height */
function rows({layer, images}, top, width, height) {
  const name = layer === "rectified" ? "Rectified" : "As seen", words = difference(images);
  const isNarrow = widthOf(name, true) + widthOf(words) + 12 > width, head = isNarrow ? 2 * LINE + 6 : LINE + 6;
  const wide = (width - GAP) / 2, high = height - head, count = images.length / 4;
  const pointsOf = (/** @type {number} */ k) =>
    Array.from({length: count}, (_, i) => [images[4 * i + k], images[4 * i + k + 1]]);
  const points = [pointsOf(0), pointsOf(2)];
  const each = points.map(around), [, lowest, , highest] = around(points.flat());
  const widest = Math.max(...each.map(([left, , right]) => right - left));
  const scale = Math.min((high - 2 * MARGIN) / (highest - lowest), (wide - 2 * MARGIN) / widest);
  const placed = points.map((of, side) => of.map(([x, y]) => [
    side * (wide + GAP) + wide / 2 + (x - (each[side][0] + each[side][2]) / 2) * scale,
    top + head + high / 2 + (y - (lowest + highest) / 2) * scale,
  ]));
  const planes = [0, 1].map(side => rectangle("vi-plane", side * (wide + GAP) + .5, top + head, wide - 1, high, 5)
    + text(side * (wide + GAP) + 8, top + head + 18, "lr"[side], "vi-name"));
  const joined = placed[0].map((p, i) => polyline([p, placed[1][i]])).join("");
  const said = isNarrow ? text(0, top + 15 + LINE, words, "vi-2nd") : text(width, top + 15, words, "vi-2nd vi-end");
  return text(0, top + 15, name, "vi-b") + said + planes.join("") + path("lesson-rows-line", joined)
    + path("vi-seen", diamonds(placed.flat(), 4.2));
}
