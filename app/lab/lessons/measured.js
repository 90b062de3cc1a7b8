/** What measures are made of: numbers with their unit as they stand in a sentence, and distances of marks.
 * @import {Measured, Mark} from "./stage.js" */
import {energyText, fixed} from "../view/svg.js";

const MISSING = "–";

/** A number in as many digits as it deserves: three that count. @param {number} value */
export const short = value => {
  const size = Math.abs(value);
  return fixed(value, size >= 100 || size === 0 ? 0 : size >= 10 ? 1 : size >= 1 ? 2
    : Math.min(4, 1 - Math.floor(Math.log10(size))));
};

/** @param {number} value NaN where there is none @param {string} [unit] with the space before it
 * @param {number | null} [digits] after the point, null for as many as it deserves
 * @param {string} [missing] text for NaN @returns {Measured} */
export function measured(value, unit = "", digits = null, missing = MISSING) {
  return {value, unit, text: Number.isFinite(value)
    ? `${digits === null ? short(value) : fixed(value, digits)}${unit}` : missing};
}

/** px², in as many digits as the lab has. @param {number} E @returns {Measured} */
export const energy = E => ({value: E, unit: " px²", text: `${energyText(E)} px²`});

/** A place or a posture, which no sentence has. @param {ArrayLike<number> | number[][]} value @returns {Measured} */
export const placed = value => ({value, unit: "", text: MISSING});

/** How far a mark is from a place, or from a line of places.
 * @param {ArrayLike<number>} mark @param {ArrayLike<number> | number[][]} truth (2,), or the corners of a line */
export function distance(mark, truth) {
  const at = nearest(mark, truth);
  return Math.hypot(mark[0] - at[0], mark[1] - at[1]);
}

/** The place of a truth that is nearest to a mark.
 * @param {ArrayLike<number>} mark @param {ArrayLike<number> | number[][]} truth @returns {Mark} */
export function nearest(mark, truth) {
  if (!Array.isArray(truth[0])) return [Number(truth[0]), Number(truth[1])];
  const corners = /** @type {number[][]} */ (truth);
  /** @type {Mark} */
  let best = [NaN, NaN];
  let least = Infinity;
  for (let k = 0; k + 1 < corners.length; k++) {
    const [[a, b], [c, d]] = [corners[k], corners[k + 1]], square = (c - a) ** 2 + (d - b) ** 2;
    const share = square > 0 ? Math.min(1, Math.max(0, ((mark[0] - a) * (c - a) + (mark[1] - b) * (d - b)) / square))
      : 0;
    const at = /** @type {Mark} */ ([a + share * (c - a), b + share * (d - b)]),
      off = Math.hypot(mark[0] - at[0], mark[1] - at[1]);
    if (off < least) [least, best] = [off, at];
  }
  return best;
}
