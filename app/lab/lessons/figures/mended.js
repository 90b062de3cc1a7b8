/**
 * Eyes turned inwards: the map of E as they see and rectified by their matches, and the matches of both eyes, which lie
 * in equal rows then.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").FigureKind} FigureKind
 * @typedef {import("../../engine/world.js").World} World
 * @typedef {{left: number[], right: number[]}} Rectification homographies of the left and the right eye, row by row
 */
import {select} from "../../engine/engine.js";
import {fixed} from "../../view/svg.js";
import {Altered, mapOf, smallest} from "../maps.js";
import {farthest} from "./bowl.js";
import {diamonds, Drawing, extent, path, polyline, rectangle, text} from "./drawing.js";
import {MapPanel} from "./panels.js";

const LAYERS = ["as seen", "rectified"], TITLES = ["As the eyes see", "Rectified by matches alone"];
const MIN_DENOMINATOR = .1; // of a homography, as of the library's: no point is at infinity
const GAP = 18, HEAD = 24, MARGIN = 14, LEAST_PX = .01;

/** @type {FigureKind} */
export const MENDED = {
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
          const {world, transfer, demo} = seenIn(stage, layer), lowest = smallest(world, transfer, demo);
          const words = lowest ? `${fixed(farthest(lowest, demonstrator))}° off` : "";
          panels[k].draw({title: TITLES[k], words, map: mapOf(world, transfer, demo), demonstrator,
            lowest: lowest ? [lowest] : [], apart: true}, stage.world.scene);
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
  create(box) {
    const drawing = new Drawing(box, "lesson-rows");
    return {
      resize: () => drawing.measure(),
      draw(stage, layers) {
        const {views, usable} = stage.moment, images = select(views.demo, usable);
        const by = /** @type {Rectification} */ (stage.records.rectification), high = drawing.height / LAYERS.length;
        const cases = LAYERS.filter(layer => layers.has(layer)).map(layer =>
          ({layer, images: layer === "rectified" ? rectified(images, by) : images}));
        const words = cases.map(each => `${each.layer}, ${difference(each.images)}`).join("; ");
        drawing.show(cases.map((each, k) => rows(each, k * high, drawing.width, high - 8)).join(""),
          `Matches of the left and the right eye: ${words}.`);
      },
    };
  },
};

/** @type {WeakMap<World, Altered>} */
const rectifiedWorlds = new WeakMap();

/** The world as it is seen, or through rectified eyes. @param {Stage} stage @param {string} layer */
export function seenIn(stage, layer) {
  const {world, session: {settings: {transfer}}} = stage;
  if (layer === "rectified" && !rectifiedWorlds.has(world)) rectifiedWorlds.set(world, new Altered(world, {
    alter: ({images, seen}) => ({images: rectified(images, stage.records.rectification), seen}),
  }));
  const used = layer === "rectified" ? /** @type {Altered} */ (rectifiedWorlds.get(world)) : world;
  return {world: used, transfer, demo: used.look("demonstrator", stage.moment.thetaDemo)};
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

/**
 * Both images beside each other, equally large and at one height.
 *
 * @param {{layer: string, images: Float64Array}} what
 * @param {number} top
 * @param {number} width
 * @param {number} height
 */
function rows({layer, images}, top, width, height) {
  const wide = (width - GAP) / 2, high = height - HEAD, count = images.length / 4;
  const pointsOf = (/** @type {number} */ k) =>
    Array.from({length: count}, (_, i) => [images[4 * i + k], images[4 * i + k + 1]]);
  const points = [pointsOf(0), pointsOf(2)];
  const each = points.map(extent), {low, high: most} = extent(points.flat());
  const widest = Math.max(...each.map(of => of.high[0] - of.low[0]));
  const scale = Math.min((high - 2 * MARGIN) / (most[1] - low[1]), (wide - 2 * MARGIN) / widest);
  const placed = points.map((of, side) => of.map(([x, y]) => [
    side * (wide + GAP) + wide / 2 + (x - (each[side].low[0] + each[side].high[0]) / 2) * scale,
    top + HEAD + high / 2 + (y - (low[1] + most[1]) / 2) * scale,
  ]));
  const planes = [0, 1].map(side => rectangle("vi-plane", side * (wide + GAP) + .5, top + HEAD, wide - 1, high, 5)
    + text(side * (wide + GAP) + 8, top + HEAD + 18, "lr"[side], "vi-name"));
  const joined = placed[0].map((p, i) => polyline([p, placed[1][i]])).join("");
  return text(0, top + 15, layer === "rectified" ? "Rectified" : "As seen", "vi-b")
    + text(width, top + 15, difference(images), "vi-2nd vi-end") + planes.join("")
    + path("lesson-rows-line", joined) + path("vi-seen", diamonds(placed.flat(), 4.2));
}
