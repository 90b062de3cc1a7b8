/** The addresses at which the lab, and the page of viewimit, open in the state of a step.
 * @import {Stage} from "./stage.js" @import {State} from "../view/address.js" */
import {fieldsOf, pageLink} from "../view/address.js";

/** @param {Stage} stage @param {string} preset @returns {State} */
function stateOf({moment, session: {settings}, state}, preset) {
  const {transfer, servo, noisePx = 0, missing = 0, seed = 7} = settings;
  return {preset, demonstrator: moment.thetaDemo, start: moment.theta, points: state.points, transfer, servo,
    noisePx, missing, seed, steps: 0};
}

/** Whether a slider has moved the eyes, as it can nowhere else. @param {Stage} stage */
const areEyesMoved = ({scene, world}) => world.scene !== scene
  && JSON.stringify(world.scene.cameras) !== JSON.stringify(scene.cameras);

/** Of the lab, with the way back; null where it has no such scene. @param {Stage} stage @param {string} back */
export function labAddress(stage, back) {
  const {preset} = stage.scene.page ?? {};
  if (!preset || areEyesMoved(stage)) return null;
  const fields = fieldsOf(stateOf(stage, preset));
  return `#${[`preset=${preset}`, ...fields, `back=${encodeURIComponent(back)}`].join("&")}`;
}

/** Of viewimit's page; null where it has no such scene. @param {Stage} stage */
export function viewimitAddress(stage) {
  const {scene = null, layouts = [], preset = ""} = stage.scene.page ?? {};
  return scene && !areEyesMoved(stage) ? `?${pageLink(stateOf(stage, preset ?? ""), scene, layouts)}` : null;
}
