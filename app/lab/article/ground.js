/** A map of E that can be touched: the learner's dot, and the demonstrator's diamond where that may be moved. */
import {Landscape} from "../engine/engine.js";
import {EnergyMap} from "../view/map.js";
import {turned} from "./views.js";

/** @import {World} from "../engine/world.js" */

/** What a screen reader says of a map. */
export const KEYS = "Map of E. Arrow keys turn the learner’s joints by 1 degree, with Shift by 5.";

const STEP_DEG = 2, GRIP_PX = 16, FINGER_PX = 24;

export class Ground {
  /** @param {import("./frame.js").Frame} frame @param {HTMLElement} box @param {World} world */
  constructor(frame, box, world) {
    this.frame = frame;
    this.box = box;
    this.map = new EnergyMap(box);
    frame.maps.push(this.map);
    this.world = world;
    this.landscape = new Landscape(world, STEP_DEG);
    this.isDue = true;
    /** The demonstrator's posture that the landscape is of. */
    this.key = "";
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
  measure() {
    this.isDue = true;
  }

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
    const {frame, box, map} = this, at = (/** @type {{clientX: number, clientY: number}} */ {clientX, clientY}) => {
      const {left, top} = box.getBoundingClientRect();
      return [(clientX - left) / map.unit, (clientY - top) / map.unit];
    };
    const posture = (/** @type {PointerEvent} */ event) => { const [x, y] = at(event); return map.posture(x, y); };
    frame.drag(box, event => {
      const from = at(event), near = event.pointerType === "touch" ? FINGER_PX : GRIP_PX;
      const away = (/** @type {number[]} */ theta) => Math.hypot(...map.place(theta).map((v, k) => v - from[k]));
      const isDemo = pose && away(demonstrator()) < near && away(learner()) > away(demonstrator());
      box.focus({preventScroll: true});
      if (event.pointerType === "touch" && !isDemo && away(learner()) > near) return null; // a swipe scrolls
      if (!isDemo) place(posture(event));
      return next => isDemo ? pose(posture(next)) : place(posture(next));
    });
    box.addEventListener("click", event => { // a tap
      if (/** @type {PointerEvent} */ (event).pointerType !== "touch") return;
      place(posture(/** @type {PointerEvent} */ (event)));
      frame.redraw();
    });
    frame.arrows(box, (right, up) => place(turned(learner(), right, up, this.world.scene)));
  }
}
