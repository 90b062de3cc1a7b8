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
import {fixed, px} from "../../view/svg.js";
import {Altered, mapOf, smallest} from "../maps.js";
import {farthest} from "./bowl.js";
import {diamonds, Drawing, path, text} from "./drawing.js";
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
    box.classList.add("lesson-panels", "lesson-panels-column");
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
        const shown = LAYERS.filter(layer => layers.has(layer)), high = drawing.height / LAYERS.length;
        const cases = shown.map(layer => ({layer, images: layer === "rectified" ? rectified(images, of(stage)) : images}));
        drawing.show(cases.map((each, k) => rows(each, k * high, drawing.width, high - 8)).join(""),
          `Matches of the left and the right eye: ${cases.map(each => `${each.layer}, ${difference(each.images)}`).join("; ")}.`);
      },
    };
  },
};

/** @param {Stage} stage @returns {Rectification} */
const of = stage => stage.records.rectification;

/** @type {WeakMap<World, Altered>} */
const rectifiedWorlds = new WeakMap();

/** The world as it is seen, or through rectified eyes. @param {Stage} stage @param {string} layer */
export function seenIn(stage, layer) {
  const {world, session: {settings: {transfer}}} = stage;
  if (layer === "rectified" && !rectifiedWorlds.has(world)) rectifiedWorlds.set(world, new Altered(world, {
    alter: ({images, seen}) => ({images: rectified(images, of(stage)), seen}),
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

/** Both images beside each other, equally large and at one height. @param {{layer: string, images: Float64Array}} what @param {number} top @param {number} width @param {number} high */
function rows({layer, images}, top, width, high) {
  const each = [(width - GAP) / 2, high - HEAD], points = [0, 1].map(side =>
    Array.from({length: images.length / 4}, (_, i) => [images[4 * i + 2 * side], images[4 * i + 2 * side + 1]]));
  const xs = points.map(of => of.map(p => p[0])), ys = points.flat().map(p => p[1]);
  const low = Math.min(...ys), tall = Math.max(...ys) - low, wide = Math.max(...xs.map(of => Math.max(...of) - Math.min(...of)));
  const scale = Math.min((each[0] - 2 * MARGIN) / wide, (each[1] - 2 * MARGIN) / tall);
  const placed = points.map((of, side) => of.map(([x, y]) => [
    side * (each[0] + GAP) + each[0] / 2 + (x - (Math.max(...xs[side]) + Math.min(...xs[side])) / 2) * scale,
    top + HEAD + each[1] / 2 + (y - low - tall / 2) * scale,
  ]));
  const planes = [0, 1].map(side => {
    const x = side * (each[0] + GAP);
    return `<rect class="vi-plane" x="${px(x + .5)}" y="${px(top + HEAD)}" width="${px(each[0] - 1)}" height="${px(each[1])}" rx="5"/>
${text(x + 8, top + HEAD + 18, "lr"[side], "vi-name")}`;
  }).join("");
  const joined = placed[0].map((p, i) => `M${px(p[0])} ${px(p[1])}L${px(placed[1][i][0])} ${px(placed[1][i][1])}`).join("");
  return `${text(0, top + 15, layer === "rectified" ? "Rectified" : "As seen", "vi-b")}${
    text(width, top + 15, difference(images), "vi-2nd vi-end")}${planes}${path("lesson-rows-line", joined)}${
    path("vi-seen", diamonds(placed.flat(), 4.2))}`;
}
