/** All figures of lessons, by the names that a lesson's file has. Each owner adds lines. */
import {landscapeKind} from "./map.js";
import {viewKind} from "./view.js";

/** @type {Record<string, import("../stage.js").FigureKind>} */
export const FIGURES = {
  l: viewKind("l"),
  r: viewKind("r"),
  L: viewKind("L"),
  R: viewKind("R"),
  landscape: landscapeKind,
};
