// @ts-nocheck
/** The player of a replay: which moment is shown, how it goes on, and what keys and hands do. */
import {Arm, transform} from "../engine/kinematics.js";
import {byId as $, fault, unpacked} from "./page.js";
import {openSpace} from "./space.js";

const PANELS = ["claims", "conflict", "angles", "path"], GLIDES = 0.75;  // share of a motion's time
const HIT = 14;  // units of a drawing, about a point

const begin = (run, meshes) => {
  const last = run.motions.length - 1, moments = run.space.moments, shownHTML = {}, still = matchMedia(
    "(prefers-reduced-motion:reduce)");
  let now = 0, playing = false, since = 0, view = null, chosen = run.panels.points.indexOf(run.chosen);
  try { view = openSpace($("space"), $("labels"), run.space, meshes); } catch (error) { console.warn(error); }
  view?.setStage(run.space.stage);
  if (!view) $("labels").textContent = "This browser draws no WebGL: all but the 3-D view is here.";

  const {chain, bases, points: body} = run.space;
  const framesOf = (who, angles) => new Arm(chain, [], bases[who]).frames(angles);
  const pointsOn = frames => body.local.map((p, i) => transform(frames[body.link[i]], p));
  const put = (id, html) => {
    if (shownHTML[id] !== html) $(id).innerHTML = shownHTML[id] = html;
  };
  const joined = ({pieces, indices}, k) => indices[k].map(i => pieces[i]).join("");
  const pose = share => {
    if (!view) return;
    const from = moments[now], to = moments[Math.min(now + 1, last)], eased = share * share * (3 - 2 * share);
    const learner = from.learner.map((angle, k) => angle + eased * (to.learner[k] - angle));
    const frames = {learner: framesOf("learner", learner), demonstrator: framesOf("demonstrator", from.demonstrator)};
    const points = Object.fromEntries(Object.entries(frames).map(([who, placed]) => [who, pointsOn(placed)]));
    view.show({frames, points, plates: from.plates, recovered: from.recovered, rays: $("rays").checked});
  };
  const show = k => {
    now = Math.max(0, Math.min(last, k));
    put("images", joined(run.panels.images[now], chosen));
    for (const id of PANELS) put(id, run.panels[id][now]);
    put("ground", run.panels.grounds[run.panels.ground[now]]);
    const words = `${run.motions[now]} of ${run.motions[last]}`;
    $("time").value = now;
    $("time").setAttribute("aria-valuetext", `after ${words} motions`);
    $("where").value = words;
    pose(0);
  };
  const tick = at => {
    if (!playing) return;
    const period = 1000 / Number($("speed").value);
    if (!since) since = at;
    while (at - since >= period && now < last) {
      since += period;
      now += 1;
      if (at - since < period || now === last) show(now);
    }
    if (now === last) { play(false); return; }
    if (!still.matches) pose(Math.min(1, (at - since) / (GLIDES * period)));
    requestAnimationFrame(tick);
  };
  const play = on => {
    if (on === playing) return;
    playing = on;
    since = 0;
    document.body.classList.toggle("playing", on);
    $("play").setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) { pose(0); return; }
    if (now === last) show(0);
    requestAnimationFrame(tick);
  };
  // A point is chosen in the images: at its place in any of them, or by its number
  const choose = point => {
    const k = run.panels.points.indexOf(point);
    if (k < 0) return;
    chosen = k;
    put("images", joined(run.panels.images[now], chosen));
  };
  const nearest = event => {
    const drawn = event.target.closest("#images svg"), view = drawn && /vi-at-([lrLR])/.exec(drawn.getAttribute("class"));
    if (!view) return -1;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(drawn.getScreenCTM().inverse());
    const away = run.panels.places[now]["lrLR".indexOf(view[1])].map(
      ([x, y]) => x === undefined ? Infinity : Math.hypot(x - at.x, y - at.y));
    const least = Math.min(...away);
    return least <= HIT ? away.indexOf(least) : -1;
  };
  const jump = k => { play(false); show(k); };
  const scheme = () => {
    const root = document.documentElement.dataset;
    root.scheme = root.scheme === "dark" ? "light" : "dark";
    if (view) view.recolour();
  };
  const faster = by => {
    const speed = $("speed");
    speed.selectedIndex = Math.max(0, Math.min(speed.length - 1, speed.selectedIndex + by));
  };
  const rays = () => { $("rays").checked = !$("rays").checked; pose(0); };
  const fit = () => view && view.fit();

  $("time").max = last;
  $("time").addEventListener("input", () => jump(Number($("time").value)));
  $("play").addEventListener("click", () => play(!playing));
  $("back").addEventListener("click", () => jump(now - 1));
  $("on").addEventListener("click", () => jump(now + 1));
  $("scheme").addEventListener("click", scheme);
  $("fit").addEventListener("click", fit);
  $("rays").addEventListener("change", () => pose(0));
  $("speed").value = last > 200 ? "25" : last > 60 ? "10" : last > 24 ? "4" : "2";
  $("images").addEventListener("click", event => choose(nearest(event)));
  if (run.panels.points.length > 1) {
    $("images").title = "Click a point, or press its number: how it is recovered";
    $("images").addEventListener("pointermove", event => {
      $("images").style.cursor = nearest(event) < 0 ? "" : "pointer";
    });
  }
  const KEYS = {
    " ": () => play(!playing), ArrowLeft: () => jump(now - 1), ArrowRight: () => jump(now + 1),
    Home: () => jump(0), End: () => jump(last), "+": () => faster(1), "-": () => faster(-1),
    PageUp: () => jump(now - 10), PageDown: () => jump(now + 10), d: scheme, v: fit, r: rays,
    n: () => choose(((run.panels.points[chosen] ?? -1) + 1) % run.panels.places[0][0].length),
  };
  for (let digit = 0; digit < 10; digit++) KEYS[digit] = () => choose(digit);
  document.addEventListener("keydown", event => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (event.ctrlKey || event.metaKey || event.altKey || !(key in KEYS)) return;
    if (event.target.matches("select,pre") || document.querySelector(":popover-open")) return;
    if (key === " " && event.target.matches("button:not(#play)")) return;
    event.preventDefault();
    KEYS[key]();
  });
  // The curves are sliders, too
  const [left, right, end] = run.axis;
  for (const id of ["conflict", "angles"]) {
    const scrub = event => {
      const box = $(id).querySelector("svg").getBoundingClientRect();
      const motion = ((event.clientX - box.left) / box.width - left) / (right - left) * end;
      let nearest = 0;
      run.motions.forEach((m, k) => {
        if (Math.abs(m - motion) < Math.abs(run.motions[nearest] - motion)) nearest = k;
      });
      if (nearest !== now) jump(nearest);
    };
    $(id).addEventListener("pointerdown", event => { $(id).setPointerCapture(event.pointerId); scrub(event); });
    $(id).addEventListener("pointermove", event => event.buttons && scrub(event));
  }
  for (const button of document.querySelectorAll(".copy")) button.addEventListener("click", async () => {
    const text = button.nextElementSibling;
    try {
      await navigator.clipboard.writeText(text.textContent);
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy"; }, 1500);
    } catch {
      getSelection().selectAllChildren(text);
    }
  });
  const asked = run.motions.indexOf(Number(location.hash.slice(1) || "0"));  // replay.html#12
  show(Math.max(asked, 0));
  globalThis.replay = {framesOf, moments};
};

if (typeof DecompressionStream === "undefined") fault("This replay needs a browser of 2023 or later.");
else Promise.all([unpacked("run").json(), unpacked("meshes").arrayBuffer()]).then(
  ([run, meshes]) => begin(run, meshes)).catch(error => { fault(`This replay is damaged: ${error.message}`); throw error; });
