/** All figures of lessons, by the names that a lesson's file has. Each owner adds lines. */
import {eye} from "./eyes.js";
import {landscapeKind} from "./map.js";
import {counts, energies, formula, predictions, progress, standings} from "./numbers.js";
import {outside} from "./outside.js";
import {energyAxis, roomFromAbove} from "./room.js";
import {dotToGoal, threeGains, turnedPicture} from "./showing.js";
import {viewKind} from "./view.js";

/** @type {Record<string, import("../stage.js").FigureKind>} */
export const FIGURES = {
  1: eye(1),
  2: eye(2),
  l: viewKind("l"),
  r: viewKind("r"),
  L: viewKind("L"),
  R: viewKind("R"),
  landscape: landscapeKind,
  outside,
  counts,
  formula,
  progress,
  standings,
  predictions,
  "room from above": roomFromAbove,
  "E axis": energyAxis,
  "three gains": threeGains,
  "turned picture": turnedPicture,
  "dot to goal": dotToGoal,
  "E of both": energies,
};
