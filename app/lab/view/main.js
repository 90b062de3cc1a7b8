/** Where the page's script begins: it unpacks what the file holds, and opens the lab or a replay on it. */
import {listen, returnFocus} from "./keys.js";
import {Lab} from "./lab.js";
import {byId as $, fault, unpacked} from "./page.js";
import {Replay} from "./replay.js";
import {View} from "./view.js";

/**
 * @typedef {import("./view.js").Common & import("./experiment.js").Offered &
 *   {run?: import("./recorded.js").Run, words?: string}} Data run: of a replay, whose presets are empty where the lab
 *   cannot take over; words: the glossary, in HTML
 */

/** @param {Data} data @param {ArrayBuffer} meshes */
function begin(data, meshes) {
  /** @type {Lab | Replay | null} */
  let shown = null;
  returnFocus();
  const view = new View(data, meshes, () => shown?.redraw());
  new ResizeObserver(() => shown?.resized()).observe($("map"));
  /** @type {Lab | null} */
  let lab = null;
  const openLab = (/** @type {string} */ address) => {
    shown = lab = new Lab(data, view, address);
    publish(lab, view);
    return lab;
  };
  const {run} = data;
  if (!run) return void openLab(location.hash);

  $("words").innerHTML = data.words ?? "";
  const takes = data.presets.length > 0;
  const takeOver = (/** @type {Partial<import("./address.js").State>} */ state, /** @type {string} */ says) => {
    replay.close();
    data.presets[0].says = says;
    lab?.open();
    const opened = lab ?? openLab("");
    shown = opened;
    opened.enter({...opened.experiment.usual, ...state});
  };
  const replay = new Replay(run, Object.values(data.scenes)[0], view, takes ? takeOver : null);
  const back = () => {
    lab?.close();
    shown = replay;
    replay.open(replay.moment.motion);
    try { history.replaceState(null, "", `#${replay.moment.motion}`); } catch { /* a frame without an address */ }
  };
  $("return").addEventListener("click", back);
  listen({t: back}, () => Boolean(lab?.isOpen));
  Object.assign(globalThis, {replay});
  if (takes && location.hash.includes("preset=")) return void openLab(location.hash);
  shown = replay;
  replay.open(Number(location.hash.slice(1)) || 0); // replay.html#12
}

/** What tests and the console can reach. @param {Lab} lab @param {View} view */
function publish(lab, {space, images, map}) {
  const {experiment, landscapes} = lab;
  Object.assign(globalThis, {lab: {
    session: () => experiment.session, world: () => experiment.world, landscape: () => landscapes.shown, minimum: () => landscapes.minimum,
    pageLink: () => experiment.pageLink(), fineMap: () => landscapes.fine(),
    pose: (/** @type {number[]} */ theta) => lab.pose(theta),
    place: (/** @type {number[]} */ theta) => lab.place(theta),
    step: () => lab.player.step(), draw: () => lab.draw(), space, images, map, drawnAt: performance.now(),
  }});
}

Promise.all([unpacked("data").json(), unpacked("meshes").arrayBuffer()])
  .then(([data, meshes]) => begin(data, meshes))
  .catch(error => { fault(`This page is damaged: ${error.message}`); throw error; });
