/** Where the page's script begins: it unpacks what the file holds, and opens the lab on it. */
import {Lab} from "./lab.js";
import {byId as $, fault, unpacked} from "./page.js";
import {View} from "./view.js";

/** @typedef {import("./view.js").Common & import("./experiment.js").Offered} Data */

/** @param {Data} data @param {ArrayBuffer} meshes */
function begin(data, meshes) {
  /** @type {Lab | null} */
  let lab = null;
  const view = new View(data, meshes, () => lab?.redraw());
  lab = new Lab(data, view, location.hash);
  const opened = lab, {experiment, landscapes} = lab;
  new ResizeObserver(() => opened.resized()).observe($("map"));
  Object.assign(globalThis, {lab: {
    session: () => experiment.session, world: () => experiment.world, landscape: () => landscapes.shown,
    pageLink: () => experiment.pageLink(), fineMap: () => landscapes.fine(),
    pose: (/** @type {number[]} */ theta) => opened.pose(theta),
    place: (/** @type {number[]} */ theta) => opened.place(theta),
    step: () => opened.player.step(), draw: () => opened.draw(),
    space: view.space, images: view.images, map: view.map, drawnAt: performance.now(),
  }});
}

if (typeof DecompressionStream === "undefined") fault("This page needs a browser of 2023 or later.");
else Promise.all([unpacked("data").json(), unpacked("meshes").arrayBuffer()])
  .then(([data, meshes]) => begin(data, meshes))
  .catch(error => { fault(`This page is damaged: ${error.message}`); throw error; });
