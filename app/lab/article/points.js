/** Four points fit anything: the map of E with four points, with five, and with more. */
import {DEGREE, recovered, World} from "../engine/engine.js";
import {Images} from "../view/images.js";
import {energyText, fixed} from "../view/svg.js";
import {Ground, KEYS} from "./ground.js";
import {DEMONSTRATOR, sessionOf, START} from "./views.js";

const FIRST = "4", LOW_PX2 = 3;

/** @type {import("./frame.js").FigureKind} */
export function points(frame, data) {
  const boxes = {l: frame.panel("l", "Picture <i>l</i>"), L: frame.panel("L", "Picture <i>L</i>")};
  const images = new Images(boxes, data.hulls), box = frame.mapPanel("ground", "E over both joints, in px²", KEYS);
  let count = FIRST, world = new World(data.scene, count), theta = START;
  let session = sessionOf(world, DEMONSTRATOR, theta);
  const ground = new Ground(frame, box, world), blank = box.appendChild(document.createElement("p"));
  blank.textContent = "E is 0 in every pose";
  blank.className = "nothing";
  const place = (/** @type {number[]} */ next) => { theta = next; };
  ground.touch(() => theta, place, () => DEMONSTRATOR, null);
  const counts = Object.keys(data.scene.layouts);
  frame.choice("Points", Object.fromEntries(counts.map(name => [name, name])), count, value => {
    count = value;
    world = new World(data.scene, count);
    session = sessionOf(world, DEMONSTRATOR, theta);
    ground.enter(world);
  });
  frame.button("Start again", () => { theta = START; });
  frame.hint.textContent = "Choose a number of points, then drag the blue dot over the map "
    + "and watch the diamonds in picture L.";

  /** How far from the demonstrator's pose E is still low somewhere, in degrees. */
  const widest = () => {
    const landscape = ground.of(DEMONSTRATOR);
    let most = 0;
    for (let g = 0; g < landscape.count; g++) if (landscape.E[g] < LOW_PX2)
      most = Math.max(most, ...landscape.posture(g).map((v, k) => Math.abs(v - DEMONSTRATOR[k]) / DEGREE));
    return most;
  };
  return {
    measure: () => [images, ground].forEach(one => one.measure()),
    draw() {
      const moment = session.observe(theta), isBlank = world.body.length < 5;
      box.classList.toggle("blank", isBlank);
      blank.hidden = !isBlank;
      ground.draw(DEMONSTRATOR, theta);
      images.draw(world, {moment, recovered: recovered(moment), lines: [], chosen: 0, goal: false, ease: 1});
      const E = `<b>${energyText(moment.E)} px²</b>`, far = isBlank ? 0 : widest();
      if (isBlank) frame.say(
        `With four points E is ${E}, here and in every pose.`, "The diamonds sit on the points, whatever the arm does.",
      );
      else frame.say(
        `With ${count} points E is ${E} here.`,
        far ? `A pose can be <b>${fixed(far, 0)}°</b> off although E is below ${LOW_PX2} px².`
          : `No pose has an E below ${LOW_PX2} px².`,
      );
    },
    state: () => ({count, theta, E: session.observe(theta).E}),
  };
}
