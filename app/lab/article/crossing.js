/** The crossing and its ellipse: two eyes give two lines, and a small angle between them makes the crossing uncertain.

 * @import {Fitted} from "../engine/transfers.js" @import {FigureKind} from "./frame.js" */
import {DEGREE, Generator, geometry, World} from "../engine/engine.js";
import {spreadOf} from "../lessons/figures/crossing.js";
import {diamonds} from "../lessons/figures/drawing.js";
import {Images} from "../view/images.js";
import {fixed} from "../view/svg.js";
import {reachable} from "./frame.js";
import {imageOf, Overlay, sessionOf} from "./views.js";

const POSE = [45 * DEGREE, -90 * DEGREE], HAND = 8, USUAL_CM = 60, USUAL_NOISE_PX = 1;
const DRAWS = 100, SEED = 7, GRIP_PX = 28;

/** @type {FigureKind} */
export function crossing(frame, data) {
  const boxes = {
    l: frame.panel("l", "Picture <i>l</i>: drag the ringed point"), r: frame.panel("r", "Picture <i>r</i>: here, too"),
    L: frame.panel("L", "Picture <i>L</i>: solid line from <i>l</i>, dashed line from <i>r</i>"),
  };
  const images = new Images(boxes, data.hulls);
  const over = {
    l: new Overlay(images, 0, ["vi-mark"]), r: new Overlay(images, 1, ["vi-mark"]),
    L: new Overlay(images, 2, ["vi-draws", "vi-found vi-over"]),
  };
  let baseline = USUAL_CM, noise = USUAL_NOISE_PX, shift = [0, 0, 0, 0], world = seenWith(USUAL_CM), now = moment();
  const draws = normals();

  /** @param {number} cm */
  function seenWith(cm) {
    const {cameras} = data.baselines.reduce((a, b) => Math.abs(b.value - cm) < Math.abs(a.value - cm) ? b : a);
    return new World({...data.scene, cameras}, 10);
  }
  function moment() { return sessionOf(world, POSE, POSE).now; }
  const mark = () => now.views.demo.slice(4 * HAND, 4 * HAND + 4).map((v, k) => v + shift[k]);
  const baselines = frame.slider({
    label: "Distance between the eyes", low: 10, high: 100, step: 5, value: baseline, text: value => `${value} cm`,
    moved: value => {
      baseline = value;
      world = seenWith(value);
      now = moment();
      images.fresh = true;
    },
  });
  const noises = frame.slider({
    label: "Pixel noise", low: 0, high: 3, step: .1, value: noise,
    text: value => `${fixed(value)} px`, moved: value => { noise = value; },
  });
  frame.button("Start again", () => {
    [baseline, noise, shift] = [USUAL_CM, USUAL_NOISE_PX, [0, 0, 0, 0]];
    world = seenWith(baseline);
    now = moment();
    images.fresh = true;
    baselines.show(baseline);
    noises.show(noise);
  });
  frame.hint.textContent = "Drag the ringed point in l or r, or press the arrow keys there: "
    + "its line moves, and the crossing with it.";
  for (const [box, view] of /** @type {const} */ ([[boxes.l, 0], [boxes.r, 1]])) {
    reachable(box, `Picture ${"lr"[view]}. Arrow keys move the ringed point by one pixel.`);
    frame.drag(box, event => {
      const at = mark().slice(2 * view), [x, y] = images.under(event, view), grip = [at[0] - x, at[1] - y];
      if (Math.hypot(...grip) * images.view(view).window.scale > GRIP_PX) return null;
      return next => {
        const seen = images.under(next, view), here = imageOf(now.views.demo, HAND, view);
        for (const k of [0, 1]) shift[2 * view + k] = seen[k] + grip[k] - here[k];
      };
    });
    frame.arrows(box, (right, up) => {
      shift[2 * view] += right;
      shift[2 * view + 1] -= up;
    });
  }

  /** Where the lines cross, how they do, and the ellipse that 95 of 100 crossings are in with this noise. */
  const construction = () => {
    const at = mark(), fitted = /** @type {Fitted} */ (now.fitted), found = fitted.recover(at);
    const all = geometry(now)?.lines(at, now.views.own.subarray(4 * HAND)) ?? [];
    const lines = all.filter(({into, from}) => into === 2 && from < 2);
    const angle = Math.asin(Math.min(1, Math.abs(lines[0].a * lines[1].b - lines[0].b * lines[1].a)));
    const {halfAxes, direction} = spreadOf(fitted, at, noise)[0];
    return {found, lines, angle, halfAxes, direction, fitted, at};
  };

  return {
    measure: () => images.measure(),
    draw() {
      const {found, lines, angle, halfAxes, direction, fitted, at} = construction();
      const recovered = now.views.demo.map(() => NaN);
      images.draw(world, {moment: now, recovered, lines, chosen: HAND, goal: false, ease: 1,
        construction: {ellipses: [{x: found[0], y: found[1], long: halfAxes[0], short: halfAxes[1], turn: direction / DEGREE}], steps: null}});
      over.l.marks("vi-mark", [at.slice(0, 2)]);
      over.r.marks("vi-mark", [at.slice(2)]);
      over.L.marks("vi-draws", noise ? draws.map(n => fitted.recover(at.map((v, k) => v + noise * n[k]))) : []);
      over.L.marks("vi-found vi-over", [found], points => diamonds(points, 4));
      frame.say(
        `The lines cross at <b>${fixed(angle / DEGREE)}°</b>.`,
        `With ${fixed(noise)} px of noise, 95 of 100 crossings lie in the ellipse.`,
        `It is <b>${fixed(2 * halfAxes[0], 0)} px</b> long and <b>${fixed(2 * halfAxes[1])} px</b> wide.`,
      );
    },
    state: () => {
      const {found, angle, halfAxes} = construction();
      return {baseline, noise, angle, halfAxes, crossing: [found[0], found[1]]};
    },
  };
}

/** Noise of l and r for a hundred crossings, with a standard deviation of 1 px. */
function normals() {
  const random = new Generator([SEED]);
  return Array.from({length: DRAWS}, () => [random.normal(), random.normal(), random.normal(), random.normal()]);
}
