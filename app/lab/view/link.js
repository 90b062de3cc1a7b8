/** The address at which the page of viewimit opens in the lab's state: a query that it reads as it reads its own. */
import {actionsOf, fieldsOf} from "./address.js";

const PRESET = "paper"; // of the page, against which a link is read
/** @type {any} every field that may differ is said */
const UNKNOWN = {};

/** @param {import("./address.js").State} state
 * @param {string} scene as the page's settings name it: a shipped one, or the text of a scene file
 * @param {string[]} layouts of body points that the scene has there */
export function pageLink(state, scene, layouts) {
  const points = layouts.includes(String(state.points)) ? state.points : Math.min(...layouts.map(Number));
  return [`preset=${PRESET}`, `scene=${encodeURIComponent(scene)}`, ...fieldsOf({...state, points}, UNKNOWN),
    "frames=1", "rectify=off", ...actionsOf(state)].join("&");
}
