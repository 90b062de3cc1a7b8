/**
 * Layers of the four images: points that bear each other's names, and the ellipse of a transferred point.
 *
 * @typedef {import("./view-layers.js").Layer} Layer
 */
import {px} from "../../view/svg.js";
import {drawnEllipse, ellipseOf} from "./crossing.js";
import {circles, path, text} from "./drawing.js";

const RING = 10, NAME = 19, EDGE = 12; // units: of a ring, from a point to its name, from there to the drawing's edge

/** @type {Record<string, Layer>} */
export const LIMITS_LAYERS = {
  "pair": (frame, stage) => {
    /** @type {number[][]} */
    const pairs = stage.records.swapped ?? [];
    return pairs.filter(pair => pair.every(i => frame.shown.includes(i))).map(([i, j]) => {
      const ends = [frame.of(frame.images, i), frame.of(frame.images, j)], long = Math.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
      const unit = [0, 1].map(k => (ends[1][k] - ends[0][k]) / Math.max(long, 1e-9));
      const d = long > 2 * RING ? `M${px(ends[0][0] + RING * unit[0])} ${px(ends[0][1] + RING * unit[1])}L${px(ends[1][0] - RING * unit[0])} ${
        px(ends[1][1] - RING * unit[1])}` : "";
      const names = ends.map((at, side) => {
        const way = side ? 1 : -1, x = at[0] + NAME * way * unit[0], y = at[1] + NAME * way * unit[1];
        return text(Math.min(Math.max(x, EDGE), frame.width - EDGE), Math.min(Math.max(y, EDGE), frame.height - EDGE) + 4.5,
          String(!side === frame.isDemo ? j : i), "lesson-pair-name vi-b vi-halo vi-mid");
      });
      return `${path("lesson-pair-case", d)}${path("lesson-pair", d)}${path("lesson-pair-ring", circles(ends, RING))}${names.join("")}`;
    }).join("");
  },
  "ellipse": (frame, stage) => {
    const found = frame.isDemo ? null : ellipseOf(stage, frame.side);
    return found ? drawnEllipse(frame.at(found.at), found.halfAxes.map(v => v * frame.scale), found.direction) : "";
  },
};
