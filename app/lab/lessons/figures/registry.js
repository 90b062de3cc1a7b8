/** All figures of lessons, by the names that a lesson's file has. Each owner adds lines. */
import {BIASES} from "./biases.js";
import {LANDSCAPE} from "./bowl.js";
import {CIRCLE_FROM_SIDE, CIRCLE_IN_L} from "./circle.js";
import {CLOUDS} from "./clouds.js";
import {CROSSING} from "./crossing.js";
import {MATCHES} from "./matches.js";
import {RECTIFIED, ROWS} from "./rectified.js";
import {BETS, CLAIM, E_HISTORY, REVIEW_OF_RUNS, RUN_IMAGES} from "./sign.js";
import {VERDICT} from "./verdict.js";
import {eye} from "./eyes.js";
import {counts, energies, formula, predictions, progress, standings} from "./numbers.js";
import {outside} from "./outside.js";
import {energyAxis, roomFromAbove} from "./room.js";
import {dotToGoal, threeGains, turnedPicture} from "./showing.js";
import {viewKind} from "./view.js";

/** @type {Record<string, import("../stage.js").FigureKind>} */
export const FIGURES = {
  1: eye(1), 2: eye(2), l: viewKind("l"), r: viewKind("r"), L: viewKind("L"), R: viewKind("R"),
  landscape: LANDSCAPE, biases: BIASES, crossing: CROSSING, matches: MATCHES, verdict: VERDICT, clouds: CLOUDS,
  rectified: RECTIFIED, rows: ROWS, "circle in L": CIRCLE_IN_L, "circle from the side": CIRCLE_FROM_SIDE,
  claim: CLAIM, "run images": RUN_IMAGES, "E history": E_HISTORY, bets: BETS, "review of runs": REVIEW_OF_RUNS,
  outside, counts, formula, progress, standings, predictions, "room from above": roomFromAbove, "E axis": energyAxis,
  "three gains": threeGains, "turned picture": turnedPicture, "dot to goal": dotToGoal, "E of both": energies,
};
