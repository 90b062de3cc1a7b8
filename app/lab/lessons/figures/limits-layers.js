/** Layers of the four images: points that bear each other's names, and the ellipse of a transferred point.
 * @import {Frame, Layer} from "./view-layers.js" */
import {clamp} from "../../engine/engine.js";
import {drawnEllipse, ellipseOf} from "./crossing.js";
import {circles, path, polyline, text} from "./drawing.js";

const RING = 10, NAME = 19, EDGE = 12; // units: of a ring, from a point to its name, from there to the drawing's edge

/** @type {Record<string, Layer>} */
export const LIMITS_LAYERS = {
  "pair": (frame, stage) => {
    /** @type {number[][]} */
    const pairs = stage.records.swapped ?? [];
    return pairs.filter(pair => pair.every(i => frame.shown.includes(i))).map(pair => {
      const [from, to] = pair.map(i => frame.of(frame.images, i)), long = Math.hypot(to[0] - from[0], to[1] - from[1]);
      const unit = [0, 1].map(k => (to[k] - from[k]) / Math.max(long, 1e-9));
      const near = from.map((v, k) => v + RING * unit[k]), far = to.map((v, k) => v - RING * unit[k]);
      const joined = long > 2 * RING ? polyline([near, far]) : "", names = frame.isDemo ? [...pair].reverse() : pair;
      const drawn = path("lesson-pair-case", joined) + path("lesson-pair", joined);
      return drawn + path("lesson-pair-ring", circles([from, to], RING))
        + named(frame, from, unit, -NAME, names[0]) + named(frame, to, unit, NAME, names[1]);
    }).join("");
  },
  "ellipse": (frame, stage) => {
    const found = frame.isDemo ? null : ellipseOf(stage, frame.side);
    return found ? drawnEllipse(frame.at(found.at), found.halfAxes.map(v => v * frame.scale), found.direction) : "";
  },
};

/** A point's name beyond a ring, within the drawing.
 * @param {Frame} frame @param {number[]} at @param {number[]} unit along the pair @param {number} by units
 * @param {number} name */
function named({width, height}, at, unit, by, name) {
  const x = clamp(at[0] + by * unit[0], EDGE, width - EDGE), y = clamp(at[1] + by * unit[1], EDGE, height - EDGE);
  return text(x, y + 4.5, String(name), "lesson-pair-name vi-b vi-halo vi-mid");
}
