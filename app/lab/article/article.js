/** The article's live figures: each begins when it comes near the window, and takes the place of its still. */
import {assumption} from "./assumption.js";
import {bowl} from "./bowl.js";
import {crossing} from "./crossing.js";
import {distance} from "./distance.js";
import {Frame} from "./frame.js";
import {lines} from "./lines.js";
import {points} from "./points.js";
import {servo} from "./servo.js";
import {stillOf} from "./still.js";

/** @type {Record<string, import("./frame.js").FigureKind>} */
const FIGURES = {lines, crossing, assumption, bowl, servo, distance, points};
const NEAR = "600px"; // from the window's edge

/** @param {import("./frame.js").Data} data */
export function begin(data) {
  const begun = /** @type {Map<string, Frame>} */ (new Map());
  const sizes = new ResizeObserver(entries => entries.forEach(({target}) => begun.get(nameOf(target))?.measure()));
  const mount = (/** @type {HTMLElement} */ place) => {
    const name = nameOf(place);
    if (begun.has(name)) return;
    const live = document.createElement("div");
    live.className = "live-now";
    place.append(live);
    place.classList.add("begun");
    const frame = new Frame(live);
    frame.figure = FIGURES[name](frame, data);
    begun.set(name, frame);
    frame.measure();
    sizes.observe(place);
  };
  const seen = new IntersectionObserver(entries => {
    for (const {isIntersecting, target} of entries) if (isIntersecting) {
      seen.unobserve(target);
      mount(/** @type {HTMLElement} */ (target));
    }
  }, {rootMargin: NEAR});
  for (const place of document.querySelectorAll("[data-live]")) seen.observe(place);
  // Maps are drawn on canvases, whose colours do not follow the theme by themselves
  const recolour = () => begun.forEach(frame => frame.measure());
  new MutationObserver(recolour).observe(document.body, {attributeFilter: ["data-theme"]});
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
  Object.assign(globalThis, {article: {begun, mount, names: Object.keys(FIGURES), stillOf}});
}

/** @param {Element} place */
const nameOf = place => /** @type {HTMLElement} */ (place).dataset.live ?? "";
