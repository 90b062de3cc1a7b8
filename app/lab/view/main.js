/** Where the page's script begins: it unpacks what the file holds, and opens the lab or a replay on it.
 * @import {Common} from "./view.js" @import {Offered} from "./experiment.js" @import {Run} from "./recorded.js" @import {State} from "./address.js"
 * @typedef {Common & Offered & {run?: Run, words?: string}} Data run: of a replay, whose presets are empty where
 * the lab cannot take over; words: the glossary, in HTML */
import {Challenges} from "../challenge/challenges.js";
import {today} from "../challenge/screen.js";
import {listen, returnFocus} from "./keys.js";
import {Lab} from "./lab.js";
import {byId as $, fault, unpacked} from "./page.js";
import {Replay} from "./replay.js";
import {View} from "./view.js";

/** @param {Data} data @param {ArrayBuffer} meshes */
function begin(data, meshes) {
  let shown = /** @type {Lab | Replay | null} */ (null);
  returnFocus();
  let lab = /** @type {Lab | null} */ (null);
  let made = /** @type {View | null} */ (null);
  const viewed = () => {
    if (!made) new ResizeObserver(() => shown?.resized()).observe($("map"));
    return made ??= new View(data, meshes, () => shown?.redraw());
  };
  const openLab = (/** @type {string} */ address) => {
    shown = lab = new Lab(data, viewed(), address);
    publish(lab, viewed());
    return lab;
  };
  const {run} = data;
  if (!run) return play(data, openLab);

  const view = viewed();
  $("words").innerHTML = data.words ?? "";
  const takes = data.presets.length > 0;
  const takeOver = (/** @type {Partial<State>} */ state, /** @type {string} */ says) => {
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

/** The lab, or the challenge that the address asks for. @param {Data} data @param {(address: string) => Lab} openLab */
function play(data, openLab) {
  const challenges = new Challenges(data);
  let lab = /** @type {Lab | null} */ (null);
  const route = () => {
    if (challenges.route()) lab?.close();
    else if (lab) lab.open();
    else {
      lab = openLab(location.hash);
      const {experiment} = lab;
      $("challenge").hidden = $("day").hidden = false;
      $("day").href = `#challenge=${today()}`;
      $("challenge").addEventListener("click", () =>
        challenges.maker.open({demonstrator: experiment.now.thetaDemo, start: experiment.state.start}));
    }
  };
  addEventListener("hashchange", route); // before the lab's own, which reads its address once it is open
  route();
}

/** What tests and the console can reach. @param {Lab} lab @param {View} view */
function publish(lab, view) {
  const {experiment, landscapes} = lab, {space, images, map} = view;
  Object.assign(globalThis, {lab: {
    session: () => experiment.session, world: () => experiment.world, landscape: () => landscapes.shown, minimum: () => landscapes.minimum,
    pageLink: () => experiment.pageLink(), fineMap: () => landscapes.fine(),
    pose: (/** @type {number[]} */ theta) => lab.pose(theta),
    place: (/** @type {number[]} */ theta) => lab.place(theta),
    placed: (/** @type {number[]} */ point) => view.place(point),
    step: () => lab.player.step(), draw: () => lab.draw(), space, images, map, drawnAt: performance.now(),
  }});
}

Promise.all([unpacked("data").json(), unpacked("meshes").arrayBuffer()])
  .then(([data, meshes]) => begin(data, meshes))
  .catch(error => { fault(`This page is damaged: ${error.message}`); throw error; });
