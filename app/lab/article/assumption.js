/** As if both stood alike: the bold assumption, with the ghost of the goal that the learner cannot see. */
import {geometry, recovered, World} from "../engine/engine.js";
import {pulled, turned} from "../view/drag.js";
import {Images} from "../view/images.js";
import {energyText, fixed} from "../view/svg.js";
import {reachable} from "./frame.js";
import {DEMONSTRATOR, imageOf, Overlay, sessionOf, START} from "./views.js";

const HAND = 8;

/** @type {import("./frame.js").FigureKind} */
export function assumption(frame, data) {
  const world = new World(data.scene, 10), session = sessionOf(world, DEMONSTRATOR, START);
  const boxes = {
    l: frame.panel("l", "Picture <i>l</i>: the demonstrator"),
    L: frame.panel("L", "Picture <i>L</i>: the learner, and its ghost in the right pose"),
  };
  const images = new Images(boxes, data.hulls), over = new Overlay(images, 2, ["vi-way"]);
  let theta = START, point = HAND, showsWay = false;
  const goal = world.look("learner", DEMONSTRATOR).images;
  const at = (/** @type {number} */ share) => START.map((v, k) => v + (1 - share) * (DEMONSTRATOR[k] - v));
  const place = (/** @type {number[]} */ next) => { theta = next; };

  const slider = frame.slider({
    label: "From the same pose to another", low: 0, high: 100, step: 1, value: 100,
    text: value => `${value} %`, moved: value => place(at(value / 100)),
  });
  const way = frame.check("Show the way to the goal", showsWay, on => { showsWay = on; });
  frame.button("Start again", () => {
    [theta, point, showsWay] = [START, HAND, false];
    slider.show(100);
    way.checked = false;
  });
  frame.hint.textContent = "Drag the arm in picture L by a blue point, or use the slider.";
  frame.drag(boxes.L, event => {
    const hit = images.hit(event, session.observe(theta));
    if (!hit || !world.body[hit.point].on) return null; // the base stays
    point = hit.point;
    return pulled(world, images, hit, event, () => theta, place);
  });

  reachable(boxes.L, "Picture L. Arrow keys turn the learner’s joints by 1 degree, with Shift by 5.");
  frame.arrows(boxes.L, (right, up) => place(turned(theta, right, up, world.scene)));

  const measured = () => {
    const moment = session.observe(theta), found = recovered(moment), {views, E} = moment;
    const [own, target, put] = [views.own, goal, found].map(images => imageOf(images, point, 2));
    let product = 0, arrows = 0, ways = 0; // of arrows followed backwards, and ways to the goal, over all points in L
    for (let i = 0; i < world.body.length; i++) for (const k of [4 * i, 4 * i + 1]) {
      const back = found[k] - views.own[k], to = goal[k] - views.own[k];
      product += back * to;
      arrows += back * back;
      ways += to * to;
    }
    const [miss, arrow] = [target, own].map(from => Math.hypot(put[0] - from[0], put[1] - from[1]));
    return {moment, found, E, arrow, miss, cosine: ways > 1 ? product / Math.sqrt(arrows * ways) : NaN};
  };

  return {
    measure: () => images.measure(),
    draw() {
      const {moment, found, E, arrow, miss, cosine} = measured(), {views} = moment;
      const lines = geometry(moment)?.lines(views.demo.subarray(4 * point), views.own.subarray(4 * point))
        .filter(({into, from}) => into === 2 && from < 2) ?? [];
      images.draw(world, {moment, recovered: found, lines, chosen: point, goal: true, ease: 1});
      over.spans("vi-way", showsWay ? world.body.map((_, i) => [imageOf(views.own, i, 2), imageOf(goal, i, 2)]) : []);
      const isSame = theta.every((v, k) => Math.abs(v - DEMONSTRATOR[k]) < 1e-3), isShown = showsWay && !isSame;
      frame.say(
        isSame ? "Both stand alike. The lines are right, and the diamonds sit on the points." : "",
        `E is <b>${energyText(E)} px²</b>.`,
        isSame ? "" : `The diamond of the ringed point is <b>${fixed(arrow, 0)} px</b> from the point,
          and <b>${fixed(miss, 0)} px</b> from where the point belongs.`,
        isShown ? `Followed backwards, the arrows have a cosine of <b>${fixed(cosine, 2)}</b>
          with the way to the goal.` : "",
      );
    },
    state: () => {
      const {E, arrow, miss, cosine} = measured();
      return {theta, point, E, arrow, miss, cosine: Number.isFinite(cosine) ? cosine : 0};
    },
  };
}
