/** Two views and a line: a mark slides along its ray, stands still in one picture and walks along a line in the other.
 * @import {FigureKind} from "./frame.js"
 * @typedef {[ArrayLike<number>, string]} Dot */
import {DEGREE, geometry, projectPoint, World} from "../engine/engine.js";
import {twoCameras} from "../lessons/rays.js";
import {Images} from "../view/images.js";
import {Outside} from "../view/outside.js";
import {fixed} from "../view/svg.js";
import {imageOf, Overlay, sessionOf} from "./views.js";

const POSE = [45 * DEGREE, -90 * DEGREE], HAND = 8, GRIP_PX = 28;
const TRAIL = 15, PLACES = 117; // dots of the trail; places on the ray that are tried under a finger
const NEAR = 0.72, FAR = 1.3, FIRST = 1.2; // shares of the mark's distance
const AZIMUTH = -78 * DEGREE, ELEVATION = 22 * DEGREE; // from where the outside is seen

/** @type {FigureKind} */
export function lines(frame, data) {
  const world = new World(data.scene, 10), {now} = sessionOf(world, POSE, POSE), unseen = now.views.demo.map(() => NaN);
  const [l, beside] = twoCameras(world); // both arms stand alike: so L sees its own as `beside` sees the demonstrator
  const frames = world.arms.demonstrator.linkFrames(POSE), body = world.arms.demonstrator.points(POSE, world.body);
  const room = frame.panel("room", "From outside: the ray of camera <i>l</i>");
  const boxes = {
    l: frame.panel("l", "Picture <i>l</i>: nothing moves"), L: frame.panel("L", "Picture <i>L</i>: along a line"),
  };
  const outside = new Outside(room, data.hulls), images = new Images(boxes, data.hulls);
  const over = {l: new Overlay(images, 0, ["vi-mark"]), L: new Overlay(images, 2, ["vi-trail", "vi-mark"])};
  let point = HAND, share = FIRST, reached = [1, FIRST];

  const place = (/** @type {number} */ at) => l.centre.map((c, i) => c + at * (body[3 * point + i] - c));
  const metres = () => Math.hypot(...place(1).map((v, i) => v - l.centre[i]));
  const line = () => geometry(now)?.lines(now.views.demo.subarray(4 * point), now.views.own.subarray(4 * point))
    .find(({into, from}) => into === 2 && from === 0);
  const move = (/** @type {number} */ to) => {
    share = Math.min(FAR, Math.max(NEAR, to));
    reached = [Math.min(reached[0], share), Math.max(reached[1], share)];
    slider.show(Math.round(100 * share));
  };
  const choose = (/** @type {number} */ next) => {
    [point, share, reached] = [next, FIRST, [1, FIRST]];
    slider.show(100 * FIRST);
  };

  const slider = frame.slider({
    label: "Slide the mark", low: 100 * NEAR, high: 100 * FAR, step: 1, value: 100 * FIRST,
    text: value => `${fixed(value / 100 * metres(), 2)} m`, moved: value => move(value / 100),
  });
  frame.button("Another point", () => choose((point + 1) % world.body.length));
  frame.button("Start again", () => choose(HAND));
  frame.hint.textContent = "Drag the mark along its ray, or along the line in picture L. "
    + "A tap on another point chooses it.";
  frame.drag(room, event => {
    const [x, y] = outside.at(place(share)), [u, v] = outside.under(event);
    return Math.hypot(x - u, y - v) > GRIP_PX ? null
      : next => move(outside.share(outside.under(next), place(0), place(1)));
  });
  frame.drag(boxes.L, event => {
    const at = projectPoint(beside, place(share)), [x, y] = images.under(event, 2);
    if (Math.hypot(at[0] - x, at[1] - y) * images.view(2).window.scale > GRIP_PX) return null;
    return next => {
      const [u, v] = images.under(next, 2), away = (/** @type {number} */ s) => {
        const seen = projectPoint(beside, place(s));
        return Math.hypot(seen[0] - u, seen[1] - v);
      };
      const shares = Array.from({length: PLACES}, (_, k) => NEAR + k / (PLACES - 1) * (FAR - NEAR));
      move(shares.reduce((a, b) => away(b) < away(a) ? b : a));
    };
  });
  for (const box of [boxes.l, boxes.L]) box.addEventListener("click", event => {
    const hit = images.hit(/** @type {PointerEvent} */ (event), now);
    if (!hit || hit.point === point) return;
    choose(hit.point);
    frame.redraw();
  });
  const seenNow = () => {
    const at = projectPoint(beside, place(share)), start = projectPoint(beside, place(1)), found = line();
    const off = found ? Math.abs(found.a * at[0] + found.b * at[1] + found.c) : NaN;
    return {at, walked: Math.hypot(at[0] - start[0], at[1] - start[1]), off};
  };

  return {
    measure() {
      outside.measure();
      const marked = Array.from({length: world.body.length}, (_, i) => body.subarray(3 * i, 3 * i + 3));
      outside.look(AZIMUTH, ELEVATION, [...marked, l.centre, beside.centre, place(FAR)]);
      images.measure();
    },
    draw() {
      const found = line(), long = reached[1] - reached[0], {at, walked, off} = seenNow();
      const trail = Array.from({length: long > .005 ? TRAIL : 0}, (_, k) => reached[0] + k / (TRAIL - 1) * long);
      const lines = found ? [found] : [];
      images.draw(world, {moment: now, recovered: unseen, lines, chosen: point, goal: false, ease: 1});
      over.l.marks("vi-mark", [imageOf(now.views.demo, point, 0)]);
      over.L.marks("vi-trail", trail.map(s => projectPoint(beside, place(s))));
      over.L.marks("vi-mark", [at]);
      outside.draw({
        bodies: [{frames, kind: "vi-demo"}],
        eyes: [{camera: l, kind: "", name: "l"}, {camera: beside, kind: "", name: "L"}],
        lines: [[l.centre, place(FAR), "vi-ray"], [beside.centre, place(share), "vi-ray-beyond"]],
        dots: [...trail.map(s => /** @type {Dot} */ ([place(s), "vi-trail"])), [place(share), "vi-mark"]],
      }, `From outside: the mark is ${fixed(share * metres(), 2)} m from camera l, on its ray`);
      if (walked < .05) frame.say(
        `The mark sits on point ${point}.`, "Slide it nearer or farther, and look at both pictures.",
      );
      else frame.say(
        `The mark is <b>${fixed(Math.abs(share - 1) * metres(), 2)} m</b> from point ${point}.`,
        "In l it has not moved at all.",
        `In L it has walked <b>${fixed(walked, 0)} px</b>, and is <b>${fixed(off)} px</b> off the line that ten
          matched points give.`,
      );
    },
    state: () => ({point, share, off: seenNow().off}),
  };
}
