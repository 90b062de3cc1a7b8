/** Both robots in 3-D. All steps share one canvas, as a page may have few of them. */
import {backProject, triangulate} from "../../engine/engine.js";
import {openSpace} from "../../view/space.js";

/**
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../../view/space.js").Vector} Vector
 */

const PLATE_M = 0.17; // m from a camera to its image plate

/** @type {{holder: HTMLElement, space: ReturnType<typeof openSpace>, scene: object | null} | null} */
let shared = null;

/** @param {Stage} stage */
function space({page}) {
  if (shared) return shared;
  const holder = document.createElement("div"), canvas = holder.appendChild(document.createElement("canvas"));
  holder.className = "space";
  canvas.tabIndex = 0;
  canvas.setAttribute("aria-label", "Both robots in 3-D. Drag to turn; arrow keys turn, plus and minus zoom.");
  const labels = holder.appendChild(document.createElement("div"));
  labels.className = "labels";
  labels.setAttribute("aria-hidden", "true");
  let opened = null;
  try { opened = openSpace(canvas, labels, page.robot, page.meshes); } catch (error) { console.warn(error); }
  if (!opened) labels.textContent = "This browser draws no WebGL: the pictures beside show the same.";
  holder.classList.toggle("flat", !opened);
  canvas.addEventListener("keydown", event => {
    const turns = {ArrowUp: [0, 20], ArrowDown: [0, -20], ArrowRight: [-20, 0], ArrowLeft: [20, 0]}[event.key];
    if (!opened || !turns && event.key !== "+" && event.key !== "-") return;
    event.preventDefault();
    event.stopPropagation();
    if (turns) opened.turn(turns[0], turns[1]);
    else opened.zoom(event.key === "+" ? .9 : 1.1);
  });
  document.documentElement.addEventListener("recolour", () => opened?.recolour());
  return shared = {holder, space: opened, scene: null};
}

/** @type {import("../stage.js").FigureKind} */
export const sceneKind = {
  layers: ["rays", "recovered", "ghost", "truth hidden"],
  title: "Both robots, from outside",
  aspect: 1.3,
  create(box, stage) {
    const one = space(stage);
    box.append(one.holder);
    if (one.scene !== stage.scene && stage.scene.stage) {
      one.space?.setStage(stage.scene.stage);
      one.scene = stage.scene;
    }
    one.space?.fit();
    return {draw: (now, layers) => one.space?.show(shown(now, layers)), remove: () => one.holder.remove()};
  },
};

/** @param {Stage} stage @param {Set<string>} layers @returns {import("../../view/space.js").Shown} */
function shown(stage, layers) {
  const {world, moment: {theta, thetaDemo, views}, chosen, step} = stage, {demonstrator, learner} = world.arms, {cameras} = world.scene;
  const triples = (/** @type {Float64Array} */ flat) => Array.from({length: flat.length / 3}, (_, i) => vector(flat.subarray(3 * i, 3 * i + 3)));
  const points = {demonstrator: triples(demonstrator.points(thetaDemo, world.body)), learner: triples(learner.points(theta, world.body))};
  const found = layers.has("recovered") ? stage.recovered() : null, size = stage.scene.stage?.size ?? 1;
  const plates = cameras.map((camera, k) => points.learner.map((_, i) => {
    const images = k < 2 ? views.demo : views.own, seen = k < 2 ? views.demoSeen : views.ownSeen, side = k & 1;
    return seen[2 * i + side] ? vector(backProject(camera, images[4 * i + 2 * side], images[4 * i + 2 * side + 1], PLATE_M * size)) : null;
  }));
  const isChosen = typeof step.chosen === "number";
  return {
    points, plates, rays: layers.has("rays"),
    frames: {demonstrator: demonstrator.linkFrames(thetaDemo), learner: learner.linkFrames(theta)},
    ghost: step.ask.kind === "pose" ? learner.linkFrames(stage.guessed) : layers.has("ghost") && !stage.truthHidden ? learner.linkFrames(thetaDemo) : null,
    recovered: points.learner.map((_, i) => found && Number.isFinite(found[4 * i]) ? vector(triangulate(world.pairs.learner, found.subarray(4 * i, 4 * i + 4))) : null),
    lines: isChosen ? cameras.map((camera, k) => {
      const who = k < 2 ? "demonstrator" : "learner";
      return /** @type {[Vector, Vector, string, number, number]} */ ([vector(camera.centre), points[who][chosen], "chosen", 1.6, .8]);
    }) : [],
  };
}

/** @param {ArrayLike<number>} p @returns {Vector} */
const vector = p => [p[0], p[1], p[2]];
