/** The servo feels its way: three laws that learn from their own steps, each from the same start. */
import {farthest, recovered, World} from "../engine/engine.js";
import {Curve} from "../view/curve.js";
import {Images} from "../view/images.js";
import {energyText, fixed} from "../view/svg.js";
import {SERVO_WORDS, told} from "../view/words.js";
import {Ground, KEYS} from "./ground.js";
import {DEMONSTRATOR, sessionOf, START} from "./views.js";

const LAWS = ["gradient", "gradient-retuned", "broyden"], FIRST = "broyden", MAX_STEPS = 400, STILL_STEPS = 6;
/** @type {Record<string, number>} ms between steps */
const PERIOD_MS = {broyden: 620, gradient: 60, "gradient-retuned": 60};

/** @type {import("./frame.js").FigureKind} */
export function servo(frame, data) {
  const world = new World(data.scene, 10), still = matchMedia("(prefers-reduced-motion: reduce)");
  const box = frame.mapPanel("ground", "The way on the map of E, which no learner has", KEYS);
  const ground = new Ground(frame, box, world);
  const images = new Images({L: frame.panel("L", "Picture <i>L</i>")}, data.hulls);
  const curve = new Curve(frame.panel("curve", "E after each step"));
  let law = FIRST, session = sessionOf(world, DEMONSTRATOR, START, law), isPlaying = false, due = 0;
  const begin = (/** @type {number[]} */ start) => {
    play(false);
    session = sessionOf(world, DEMONSTRATOR, start, law);
  };
  const advance = () => session.now.motion < MAX_STEPS && session.step();
  const tick = (/** @type {number} */ time) => {
    if (!isPlaying) return;
    if (time >= due) {
      due = time + PERIOD_MS[law];
      if (!advance()) play(false);
      frame.redraw();
    }
    requestAnimationFrame(tick);
  };
  const play = (/** @type {boolean} */ on) => {
    isPlaying = on;
    playing.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (still.matches) { // nothing moves by itself: the end at once
      while (advance());
      play(false);
    } else requestAnimationFrame(tick);
  };
  frame.choice("It learns by", Object.fromEntries(LAWS.map(name => [name, SERVO_WORDS[name].title])), law, value => {
    law = value;
    begin(session.settings.start);
  });
  const playing = frame.button("Play", () => play(!isPlaying));
  frame.button("Step", () => {
    play(false);
    advance();
  });
  frame.button("Start again", () => begin(session.settings.start));
  ground.touch(() => session.settings.start, begin, () => DEMONSTRATOR, null);
  frame.hint.textContent = "Press Play, then try another law from the same start. "
    + "Drag the blue dot to begin elsewhere.";
  for (let k = 0; k < STILL_STEPS; k++) advance();

  return {
    measure: () => [images, ground, curve].forEach(one => one.measure()),
    draw() {
      const {now, trace} = session;
      const path = trace.slice(0, -1).map(({theta}, k) => ({theta, probe: trace[k + 1].probe}));
      ground.draw(DEMONSTRATOR, now.theta, path);
      images.draw(world, {moment: now, recovered: recovered(now), lines: [], chosen: 8, goal: true, ease: 1});
      curve.draw(trace);
      const off = farthest(now.theta, DEMONSTRATOR);
      const ended = now.motion >= MAX_STEPS ? "max-motions" : now.status;
      const {label, says, dot} = told(ended, {steps: now.motion, E: now.E, seen: now.usable.length});
      frame.say(
        SERVO_WORDS[law].says,
        `<i class="state ${dot}"></i><b>${label}.</b> ${says}`,
        `E is <b>${energyText(now.E)} px²</b>, and the arm is <b>${fixed(off)}°</b> off, which it cannot know.`,
      );
    },
    state: () => ({law, motion: session.now.motion, theta: session.now.theta, E: session.now.E}),
  };
}
