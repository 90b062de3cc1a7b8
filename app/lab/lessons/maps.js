/** Maps of E for the figures of lessons, and where E is smallest. Images are projected once for each world, so that
 * moving the demonstrator costs transfers only.
 * @import {Look, Who} from "../engine/world.js" @import {Stage} from "./stage.js" */
import {DEGREE, energyAt, Landscape, lowest, matched, TRANSFERS, World} from "../engine/engine.js";
import {median} from "../engine/algebra.js";
import {once} from "../view/once.js";

const MOVING_DEG = 3; // of maps that a slider of the eyes updates
const WORST_CONDITION = 1e6;
export const MAP_DEG = 2;

/** A world with other images, other points, or a part of the joints' range. */
export class Altered extends World {
  /** @param {World} world @param {Object} changes @param {World["body"]} [changes.body]
   * @param {number[]} [changes.lower] rad @param {number[]} [changes.upper]
   * @param {(look: Look, who: Who, theta: ArrayLike<number>) => Look} [changes.alter] */
  constructor(world, {body = world.body, lower = world.scene.lower, upper = world.scene.upper, alter = look => look}) {
    super({...world.scene, lower, upper});
    this.body = body;
    this.of = world;
    this.alter = alter;
  }

  /** @override @param {Who} who @param {ArrayLike<number>} theta */
  look(who, theta) {
    const seen = this.of.body === this.body ? this.of.look(who, theta) : super.look(who, theta);
    return this.alter(seen, who, theta);
  }
}

/** @param {string} transfer @param {Look} demo */
const seenBy = (transfer, demo) => `${transfer} ${demo.images.join()} ${demo.seen.join("")}`;

/** The map of E. The same one comes back until something is asked for that changes it.
 * @param {World} world @param {string} transfer @param {Look} demo images of the demonstrator
 * @param {number} [stepDeg] @returns {{landscape: Landscape, key: string}} key: differs where E does */
export function mapOf(world, transfer, demo, stepDeg = MAP_DEG) {
  const key = seenBy(transfer, demo), landscape = once(world, `grid ${stepDeg}`, () => new Landscape(world, stepDeg));
  once(landscape, "E", () => landscape.evaluate(transfer, demo), key);
  return {landscape, key};
}

/** Where a function of the posture is smallest, near the lowest posture of its map; null where that is nowhere known.
 * @param {Landscape} map @param {(theta: number[]) => number} of */
export const lowestOf = ({minimum, stepDeg, world}, of) => minimum && lowest(of, minimum.theta, stepDeg * DEGREE, world.scene);

/** The posture where E is smallest, null where it is nowhere known.
 * @param {World} world @param {string} transfer @param {Look} demo
 * @param {number} [stepDeg] of the map where the search begins @returns {number[] | null} rad */
export const smallest = (world, transfer, demo, stepDeg = MAP_DEG) => once(world, "smallest", () =>
  lowestOf(mapOf(world, transfer, demo, stepDeg).landscape, at => energyAt(world, transfer, demo, at)), seenBy(transfer, demo));

/** The median of cond(A) over the postures of a grid.
 * @param {World} world @param {string} transfer @param {Look} demo @param {number} stepDeg */
export const medianCondition = (world, transfer, demo, stepDeg) => once(world, "condition", () => {
  const grid = new Landscape(world, stepDeg), found = [];
  for (let g = 0; g < grid.count; g++) {
    const used = matched(world, demo, grid.posture(g));
    if (used) found.push(Math.min(TRANSFERS[transfer].fit(used.demo, used.own).condition, WORST_CONDITION));
  }
  return median(found);
}, `${stepDeg} ${seenBy(transfer, demo)}`);

/** Images of the demonstrator, with swapped points if the step has some. @param {Stage} stage @returns {Look} */
function demoLook(stage) {
  const look = stage.session.observer.demo(stage.moment.thetaDemo), swapped = stage.records.swapped ?? [];
  return swapped.length ? exchanged(look, swapped) : look;
}

/** A look whose points bear each other's names. @param {Look} look @param {number[][]} pairs @returns {Look} */
function exchanged({images, seen}, pairs) {
  const order = Array.from({length: seen.length / 2}, (_, i) => i);
  for (const [i, j] of pairs) [order[i], order[j]] = [order[j], order[i]];
  const from = new Float64Array(images.length), shown = new Uint8Array(seen.length);
  order.forEach((i, k) => {
    from.set(images.subarray(4 * i, 4 * i + 4), 4 * k);
    shown.set(seen.subarray(2 * i, 2 * i + 2), 2 * k);
  });
  return {images: from, seen: shown};
}

/** A coarser map where the eyes can be moved, so that it keeps up with the slider. @param {Stage} stage */
const stepOf = ({step}) => Object.keys(step.variants ?? {}).length ? MOVING_DEG : MAP_DEG;

/** The map of a step. @param {Stage} stage @param {number} [stepDeg] */
export const stageMap = (stage, stepDeg = stepOf(stage)) =>
  mapOf(stage.world, stage.session.settings.transfer, demoLook(stage), stepDeg);

/** Where the map of a step is lowest, between the postures of its grid too, rad. @param {Stage} stage */
export const stageSmallest = stage =>
  smallest(stage.world, stage.session.settings.transfer, demoLook(stage), stepOf(stage));
