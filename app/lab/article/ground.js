/** A map of E that can be touched: the learner's dot, and the demonstrator's diamond where that may be moved.
 * @import {World} from "../engine/world.js" @import {Frame} from "./frame.js" */
import {Landscape} from "../engine/engine.js";
import {EnergyMap} from "../view/map.js";
import {touchMap} from "../view/drag.js";

/** What a screen reader says of a map. */
export const KEYS = "Map of E. Arrow keys turn the learner’s joints by 1 degree, with Shift by 5.";

const STEP_DEG = 2;

export class Ground {
  /** @param {Frame} frame @param {HTMLElement} box @param {World} world */
  constructor(frame, box, world) {
    this.frame = frame;
    this.box = box;
    this.map = new EnergyMap(box);
    frame.maps.push(this.map);
    this.world = world;
    this.landscape = new Landscape(world, STEP_DEG);
    this.isDue = true;
    this.key = ""; // the demonstrator's posture that the landscape is of
  }

  /** @param {World} world */
  enter(world) {
    this.world = world;
    this.landscape = new Landscape(world, STEP_DEG);
    this.isDue = true;
    this.key = "";
  }

  /** E over all postures, for the images of the demonstrator there. @param {number[]} demonstrator */
  of(demonstrator) {
    if (this.key === demonstrator.join()) return this.landscape;
    this.key = demonstrator.join();
    this.landscape.evaluate("epipolar", this.world.look("demonstrator", demonstrator));
    this.isDue = true;
    return this.landscape;
  }

  /** The size of the map or its colours have changed. */
  measure() { this.isDue = true; }

  /** @param {number[]} demonstrator @param {number[]} learner @param {{theta: number[], probe: boolean}[]} [path] */
  draw(demonstrator, learner, path = []) {
    const landscape = this.of(demonstrator), {lower, upper, names} = this.world.scene;
    if (this.isDue) this.map.ground(landscape, {lower, upper, joints: names});
    this.isDue = false;
    this.map.marks({
      demonstrator, learner, minimum: landscape.minimum?.theta ?? null,
      path: path.map(one => ({...one, isPast: false})),
    });
  }

  /** What hands and keys do.
   * @param {() => number[]} learner @param {(theta: number[]) => void} place @param {() => number[]} demonstrator
   * @param {((theta: number[]) => void) | null} pose null where the demonstrator stays */
  touch(learner, place, demonstrator, pose) {
    const {frame, box, map} = this, then = (/** @type {(theta: number[]) => void} */ act) => (/** @type {number[]} */ theta) => {
      act(theta);
      frame.redraw();
    };
    box.addEventListener("pointerdown", () => box.focus({preventScroll: true}), true);
    touchMap(map, (element, begin) => frame.drag(element, begin), {
      learner, demonstrator, limits: () => this.world.scene, place: then(place), pose: pose && then(pose),
    });
  }
}
