/** Why it is off: perspective, which fades as the eyes move back and zoom in. */
import {DEGREE, energyAt, farthest, lowest, recovered, World} from "../engine/engine.js";
import {Chart} from "../lessons/figures/chart.js";
import {Images} from "../view/images.js";
import {energyText, fixed} from "../view/svg.js";
import {Ground} from "./ground.js";
import {sessionOf} from "./views.js";

const TIMES = [1, 2, 5, 10]; // of the chart's axis
const POSE = [45 * DEGREE, -90 * DEGREE], STEP_RAD = DEGREE; // of the search for the lowest E

/** @type {import("./frame.js").FigureKind} */
export function distance(frame, data) {
  const images = new Images({L: frame.panel("L", "Picture <i>L</i>, in exactly the right pose")}, data.hulls);
  const rigs = data.distances.map(({value, cameras}) => {
    const world = new World({...data.turned, cameras}, 10), {now} = sessionOf(world, POSE, POSE);
    return {value, world, now, shift: NaN, lowest: POSE};
  });
  const box = frame.mapPanel("ground", "The map of E: cross and diamond",
    "Map of E: the cross is the lowest E, the diamond the demonstrator’s pose.");
  box.removeAttribute("tabindex");
  const ground = new Ground(frame, box, rigs[0].world);
  const chart = new Chart(frame.panel("chart", "Both against the distance"));
  let k = 0;
  const slider = frame.slider({
    label: "Distance of the eyes", low: 0, high: rigs.length - 1, step: 1, value: 0,
    text: at => `${fixed(rigs[at].value)} ×`, moved: at => go(at),
  });
  const go = (/** @type {number} */ at) => {
    k = at;
    ground.enter(rigs[k].world);
    images.fresh = true;
  };
  frame.button("Start again", () => {
    go(0);
    slider.show(0);
  });
  frame.hint.textContent = "Move the eyes back. They zoom in at the same time, so the arms stay about as large.";
  /** How far the lowest E is from the truth, in degrees. @param {typeof rigs[number]} rig */
  const shiftOf = rig => {
    if (Number.isNaN(rig.shift)) {
      const demo = rig.world.look("demonstrator", POSE);
      rig.lowest = lowest(theta => energyAt(rig.world, "epipolar", demo, theta), POSE, STEP_RAD, rig.world.scene);
      rig.shift = farthest(rig.lowest, POSE);
    }
    return rig.shift;
  };

  return {
    measure: () => [images, ground, chart.plane].forEach(one => one.measure()),
    draw() {
      const {world, now, value} = rigs[k];
      images.draw(world, {moment: now, recovered: recovered(now), lines: [], chosen: 8, goal: false, ease: 1});
      ground.draw(POSE, POSE);
      const x = rigs.map(rig => Math.log(rig.value)), named = Math.round(rigs.length * .6);
      const shares = (/** @type {number[]} */ of) => of.map((v, i) => [x[i], v / of[0]]);
      const arrows = shares(rigs.map(rig => Math.sqrt(rig.now.E))), shifts = shares(rigs.map(shiftOf));
      const least = Math.min(...[...arrows, ...shifts].map(([, share]) => share));
      chart.draw({x: [0, x[x.length - 1]], y: [least, 1], log: true, xTicks: TIMES.map(each => [Math.log(each), `${each}×`])}, [
        {points: arrows, role: "E", name: "arrows", named}, {points: shifts, role: "learner", name: "shift", named},
        {points: [arrows[k]], role: "E", line: false}, {points: [shifts[k]], role: "learner", line: false},
      ], "Arrows, and the shift of the lowest E, over the distance");
      frame.say(
        k ? `At ${fixed(value)} times the distance:` : "",
        `The arm stands exactly right, and E is <b>${energyText(now.E)} px²</b>.`,
        `A typical arrow is <b>${fixed(Math.sqrt(now.E), 2)} px</b> long.`,
        `The lowest E is <b>${fixed(shiftOf(rigs[k]), 2)}°</b> from the truth.`,
      );
    },
    state: () => ({distance: rigs[k].value, E: rigs[k].now.E, shift: shiftOf(rigs[k])}),
  };
}
