/** The addresses at which the lab, and the page of viewimit, open in the state of a step. */
import {pageLink} from "../view/link.js";

/** @typedef {import("./stage.js").Stage} Stage */

const DEGREE = Math.PI / 180;

/** @param {Stage} stage @returns {import("../view/address.js").State} */
function stateOf({moment, session: {settings}, state}) {
  const {transfer, servo, noisePx = 0, missing = 0, seed = 7} = settings;
  return {preset: "paper", demonstrator: moment.thetaDemo, start: moment.theta, points: state.points, transfer, servo,
    noisePx, missing, seed, steps: 0};
}

/** Of the lab, with the way back. @param {Stage} stage @param {string} back */
export function labAddress(stage, back) {
  const {demonstrator, start, points, transfer, servo, noisePx, missing, seed} = stateOf(stage);
  const degrees = (/** @type {number[]} */ angles) => angles.map(v => Number((v / DEGREE).toFixed(2))).join();
  return `#demo=${degrees(demonstrator)}&start=${degrees(start)}&points=${points}&transfer=${transfer}&law=${servo}&noise=${noisePx}&lost=${Number((100 * missing).toFixed(3))}&seed=${seed}&back=${encodeURIComponent(back)}`;
}

/** Of viewimit's page; null where it has no such scene. @param {Stage} stage */
export const viewimitAddress = stage => stage.scene.page
  ? `?s=${pageLink(stateOf(stage), stage.scene.page.scene, stage.scene.page.layouts)}` : null;
