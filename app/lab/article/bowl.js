/** E and its bowl: the map of E over both joints of the learner, and its arm in the posture that is touched. */
import {farthest, recovered, World} from "../engine/engine.js";
import {Images} from "../view/images.js";
import {energyText, fixed} from "../view/svg.js";
import {Ground, KEYS} from "./ground.js";
import {DEMONSTRATOR, sessionOf, START} from "./views.js";


/** @type {import("./frame.js").FigureKind} */
export function bowl(frame, data) {
  const world = new World(data.scene, 10), session = sessionOf(world, DEMONSTRATOR, START);
  const box = frame.mapPanel("ground", "E over both joints, in px²: lowest at the cross", KEYS);
  const ground = new Ground(frame, box, world);
  const images = new Images({L: frame.panel("L", "Picture <i>L</i> in this pose")}, data.hulls);
  let theta = START, demonstrator = DEMONSTRATOR;
  const place = (/** @type {number[]} */ next) => { theta = next; };
  const pose = (/** @type {number[]} */ next) => {
    demonstrator = next;
    session.pose(next);
  };
  ground.touch(() => theta, place, () => demonstrator, pose);
  frame.button("Go to the lowest E", () => { theta = ground.of(demonstrator).minimum?.theta ?? theta; });
  frame.button("Go to the demonstrator’s pose", () => { theta = demonstrator; });
  frame.button("Start again", () => {
    pose(DEMONSTRATOR);
    theta = START;
  });
  frame.hint.textContent = "Drag the blue dot, the learner’s pose, over the map. "
    + "Drag the diamond to pose the demonstrator: the bowl goes with it.";

  return {
    measure: () => [images, ground].forEach(one => one.measure()),
    draw() {
      const moment = session.observe(theta), {minimum} = ground.of(demonstrator);
      ground.draw(demonstrator, theta);
      images.draw(world, {moment, recovered: recovered(moment), lines: [], chosen: 8, goal: true, ease: 1});
      frame.say(`E is <b>${energyText(moment.E)} px²</b> here.`, `The lowest E on the map is
        <b>${energyText(minimum?.E ?? NaN)} px²</b>, and lies <b>${fixed(farthest(minimum?.theta ?? theta, demonstrator), 0)}°</b>
        from the demonstrator’s pose.`);
    },
    state: () => {
      const {E} = session.observe(theta), {minimum} = ground.of(demonstrator);
      return {theta, demonstrator, E, lowest: minimum?.E ?? NaN};
    },
  };
}
