/** The lab: what it shows, what hands and keys do, and when it computes. The method itself is in ../engine. */
import {backProject, geometry, Landscape, MIN_POINTS, projectPoint, reachFor, recovered, select, Session, transform, triangulate, World} from "../engine/engine.js";
import {beginning, fromAddress, toAddress} from "./address.js";
import {Curve} from "./curve.js";
import {draggable} from "./drag.js";
import {Images} from "./images.js";
import {pageLink} from "./link.js";
import {EnergyMap} from "./map.js";
import {byId as $, fault, unpacked} from "./page.js";
import {Sliders} from "./sliders.js";
import {openSpace} from "./space.js";
import {energyText, fixed, say} from "./svg.js";
import {missText, outcome, SERVO_WORDS, TRANSFER_WORDS, truth} from "./words.js";

/**
 * @typedef {import("../engine/world.js").Scene & {stage: import("./space.js").Stage, page: {scene: string, layouts: string[]}}} Scene
 *   page: how the page of viewimit names it
 * @typedef {{scenes: Record<string, Scene>, presets: import("./address.js").Preset[], robot: import("./space.js").Common,
 *   hulls: Record<string, number[][]>}} Data
 * @typedef {import("../engine/session.js").Moment} Moment
 * @typedef {import("./space.js").Vector} Vector
 */

const DEGREE = Math.PI / 180, PLATE_M = 0.17; // m from a camera to its image plate
const FINE_DEG = 1, QUICK_DEG = 2, SLOW_QUICK_DEG = 4; // steps of the map: at rest, while something moves, for slow transfers
const SLICE_MS = 7, REST_MS = 120;
const PERIOD_MS = {broyden: 620, gradient: 60, "gradient-retuned": 60}, PROBE_MS = 1100, COPY_MS = 400, GLIDE = 0.75; // share of a period in which the arm moves
const GRIP_PX = 30, FINGER_PX = 24, MAX_PATH = 400; // postures drawn on the map
const HAND_OFFSET = [0, 0, 0.1]; // m, from the last link's frame to between its fingers

/** @param {Data} data @param {ArrayBuffer} meshes */
function begin(data, meshes) {
  const still = matchMedia("(prefers-reduced-motion: reduce)"), space = opened(data, meshes);
  /** @type {string[]} what the address says wrongly */
  let misread = [];
  let state = fromAddress(location.hash, data.presets, data.scenes, misread);
  const preset = () => data.presets.find(({name}) => name === state.preset) ?? data.presets[0];
  let scene = data.scenes[data.presets[0].scene], world = new World(scene), session = /** @type {Session} */ (/** @type {unknown} */ (null));
  /** @type {Map<number, Landscape>} */
  let landscapes = new Map();
  /** @type {Landscape | null} */
  let shownLandscape = null;
  let posedAt = 0; // the motion at which the demonstrator moved last
  let chosen = 0, playing = false, isHeld = false, shownScene = "";
  /** @type {{from: number[], began: number, lasts: number} | null} */
  let glide = null;

  const images = new Images({L: $("L"), R: $("R"), l: $("l"), r: $("r")}, data.hulls), map = new EnergyMap($("map")), curve = new Curve($("curve"));
  const hold = (/** @type {boolean} */ held) => { isHeld = held; if (!held) settle(); };
  const sliders = {
    demo: new Sliders($("demo"), "demonstrator", (joint, angle) => pose(session.now.thetaDemo.map((v, k) => k === joint ? angle : v)), hold),
    own: new Sliders($("own"), "learner", (joint, angle) => place(session.now.theta.map((v, k) => k === joint ? angle : v)), hold),
  };

  // Beginning, and changing what it is about

  /** @param {import("./address.js").State} target */
  function enter(target) {
    state = target;
    scene = data.scenes[preset().scene];
    world = new World(scene, state.points);
    landscapes = new Map();
    shownLandscape = null;
    if (shownScene !== preset().scene) {
      space?.setStage(scene.stage);
      images.fresh = true;
      shownScene = preset().scene;
    }
    for (const each of Object.values(sliders)) each.build(scene.names, scene.lower, scene.upper);
    const {transfer, servo, demonstrator, start, noisePx, missing, seed} = state;
    posedAt = 0;
    session = new Session(world, {transfer, servo, demonstrator, start, noisePx, missing, seed});
    while (session.now.motion < state.steps && session.step());
    chosen = farthestOff(session.now);
    glide = null;
    $("preset").value = state.preset;
    fillForm();
    updateMap();
    redraw();
  }

  /** The same experiment with other fields, from the start. @param {Partial<import("./address.js").State>} changes */
  const restart = changes => {
    const isPlaying = playing;
    misread = [];
    enter({...current(), steps: 0, ...changes});
    if (isPlaying) wake();
    remember();
  };

  /** @returns {import("./address.js").State} */
  const current = () => {
    const {theta, thetaDemo: demonstrator, motion} = session.now, begun = {start: session.settings.start, steps: motion};
    return {...state, demonstrator, ...posedAt ? {start: theta, steps: 0} : begun}; // no address tells how it moved
  };

  /** @param {number[]} theta */
  function pose(theta) {
    session.pose(theta);
    posedAt = session.now.motion;
    updateMap();
    if (playing) wake();
    redraw();
    remember();
  }

  /** The learner begins again from a posture. @param {number[]} theta */
  function place(theta) {
    posedAt = 0;
    session.begin({...session.settings, demonstrator: session.now.thetaDemo, start: theta});
    glide = null;
    if (playing) wake();
    redraw();
    remember();
  }

  let remembering = 0;
  const isServed = /\/lab$/.test(location.pathname) && location.protocol !== "file:";
  const remember = () => {
    clearTimeout(remembering);
    remembering = setTimeout(() => {
      if (isServed) $("open").href = `./?s=${linkOfPage()}`;
      try { history.replaceState(null, "", toAddress(current(), preset(), scene)); } catch { /* a frame without an address */ }
    }, 250);
  };

  // The map of E: a quick one at once, the fine one in slices once nothing moves

  /** @param {number} step */
  const landscapeOf = step => {
    if (!landscapes.has(step)) landscapes.set(step, new Landscape(world, step));
    return /** @type {Landscape} */ (landscapes.get(step));
  };
  let job = 0, resting = 0;
  const showMap = (/** @type {Landscape} */ landscape) => {
    shownLandscape = landscape;
    map.ground(landscape, {lower: scene.lower, upper: scene.upper, joints: scene.names});
  };
  const updateMap = () => {
    job++;
    const quick = landscapeOf(state.transfer === "projective" ? SLOW_QUICK_DEG : QUICK_DEG);
    quick.evaluate(state.transfer, demoLook());
    showMap(quick);
    if (!isHeld) settle();
  };
  const demoLook = () => ({images: session.now.views.demo, seen: session.now.views.demoSeen});
  const settle = () => {
    clearTimeout(resting);
    resting = setTimeout(refine, REST_MS);
  };
  const refine = () => {
    const mine = ++job, fine = landscapeOf(FINE_DEG), look = demoLook();
    let at = 0;
    const slice = () => {
      if (mine !== job || isHeld) return;
      const until = performance.now() + SLICE_MS;
      while (at < fine.count && performance.now() < until) fine.evaluate(state.transfer, look, at, at = Math.min(fine.count, at + 256));
      if (at < fine.count) return void setTimeout(slice);
      showMap(fine);
      redraw();
    };
    slice();
  };

  // Playing: while it is on, a learner at rest wakes when the demonstrator moves

  let isTicking = false, isAsleep = false, due = 0;
  /** @type {Moment | null} at which the servo had no motion to make */
  let restedAt = null;
  const advance = () => {
    const from = session.now.theta;
    if (!session.step()) {
      restedAt = session.now;
      return false;
    }
    const usual = session.now.probe ? PROBE_MS : PERIOD_MS[/** @type {keyof typeof PERIOD_MS} */ (state.servo)], period = usual * (isHeld ? .25 : 1);
    glide = still.matches || period < 100 ? null : {from, began: performance.now(), lasts: GLIDE * period};
    due = performance.now() + period;
    remember();
    return true;
  };
  const tick = (/** @type {number} */ now) => {
    if (glide && now - glide.began >= glide.lasts) glide = null;
    if (playing && !glide && now >= due && !advance()) {
      isAsleep = true;
      if (!session.now.fitted) play(false);
    }
    draw();
    if (glide || playing && !isAsleep) requestAnimationFrame(tick);
    else isTicking = false;
  };
  const wake = () => {
    isAsleep = false;
    if (isTicking) return;
    isTicking = true;
    requestAnimationFrame(tick);
  };
  const play = (/** @type {boolean} */ on) => {
    playing = on;
    document.body.classList.toggle("playing", on);
    if (on) wake();
    redraw();
  };
  const step = () => {
    play(false);
    glide = null;
    if (advance()) wake();
    redraw();
  };
  const isAtRest = () => session.now === restedAt && Boolean(session.now.fitted);
  const undo = () => {
    play(false);
    glide = null;
    session.undo();
    redraw();
    remember();
  };
  /** First the learner goes back to its start, then both go back to the poses of the experiment. */
  const reset = () => {
    play(false);
    glide = null;
    posedAt = 0;
    const {demonstrator, start} = beginning(preset(), scene);
    if (session.now.motion) session.begin({...session.settings, demonstrator: session.now.thetaDemo});
    else session.begin({...session.settings, demonstrator, start});
    updateMap();
    redraw();
    remember();
  };

  // A screen reader hears the sentence once it stays the same for a while

  let announced = "", announcing = 0;
  const announce = (/** @type {string} */ text) => {
    announced = text;
    clearTimeout(announcing);
    announcing = setTimeout(() => say($("announced"), `${text} ${$("truth").textContent}`), playing && !isAsleep ? 800 : 150);
  };

  // Drawing

  let isDue = false;
  const redraw = () => {
    if (isDue) return;
    isDue = true;
    requestAnimationFrame(() => { if (isDue && !isTicking) draw(); isDue = false; });
  };
  /** The moment on display: the present one, or one on the way there. */
  const shown = () => {
    if (!glide) return session.now;
    const share = Math.min(1, (performance.now() - glide.began) / glide.lasts), eased = share * share * (3 - 2 * share), {from} = glide;
    return session.observe(session.now.theta.map((v, k) => from[k] + eased * (v - from[k])));
  };
  const draw = () => {
    const now = session.now, moment = shown(), found = recovered(moment), {views, theta, thetaDemo} = moment, goal = $("goal").checked;
    const at = (/** @type {Float64Array} */ of) => of.subarray(4 * chosen, 4 * chosen + 4);
    const lines = moment.usable.includes(chosen) ? geometry(moment)?.lines(at(views.demo), at(views.own)) ?? [] : [];
    const moves = images.draw(world, {moment, recovered: found, lines, chosen, goal, ease: still.matches ? 1 : isHeld ? .12 : .2});
    const visited = session.trace.slice(0, glide ? -1 : undefined), path = visited.map((one, k) =>
      ({theta: one.theta, probe: Boolean(session.trace[k + 1]?.probe), isPast: one.motion < posedAt})).slice(-MAX_PATH);
    const minimum = world.body.length < MIN_POINTS || !moment.fitted || !goal ? null : shownLandscape?.minimum?.theta ?? null;
    map.marks({demonstrator: goal ? thetaDemo : null, learner: theta, minimum, path});
    curve.draw(session.trace);
    say($("E"), energyText(moment.E));
    say($("miss"), moment.fitted ? `a typical miss of ${missText(moment.E)}` : "no E: too few points");
    $("map").classList.toggle("blank", !moment.fitted);
    document.body.classList.toggle("goalless", !goal);
    say($("missed"), missed(moment, found));
    sliders.demo.show(thetaDemo, thetaDemo);
    sliders.own.show(theta, thetaDemo);
    const said = outcome(now, playing, world.body.length, Boolean(state.noisePx));
    $("state").className = `state ${said.state}`;
    say($("outcome"), said.text);
    if (said.text !== announced) announce(said.text);
    say($("truth"), goal ? truth(theta, thetaDemo, scene.names, moment.E) : "The goal is hidden, from you as from the learner.");
    say($("count"), `${now.motion} ${now.motion === 1 ? "step" : "steps"}`);
    const used = now.usable.length, all = world.body.length;
    say($("used"), used < all ? `${used} of ${all} points seen in all four pictures` : "");
    const radius = /** @type {any} */ (now.servoState)?.radius;
    say($("trust"), radius && now.motion > 2 && now.status === "moving" ? `plans at most ${fixed(radius / DEGREE, radius < 2 * DEGREE ? 1 : 0)}° ahead` : "");
    const isFollowing = playing && isAsleep, usual = beginning(preset(), scene);
    say($("play").querySelector("b"), isFollowing ? "Following" : playing ? "Pause" : "Play");
    $("play").disabled = world.body.length < MIN_POINTS;
    $("step").disabled = isAtRest();
    $("undo").disabled = !now.motion;
    $("reset").disabled = !now.motion && same(now.thetaDemo, usual.demonstrator) && same(now.theta, usual.start);
    drawSpace(moment, found, goal, lines);
    if (moves && !isTicking) redraw();
  };
  /** How far the chosen point's arrows reach. @param {Moment} moment @param {Float64Array} found */
  const missed = ({views}, found) => {
    const far = [0, 2].map(k => Math.hypot(found[4 * chosen + k] - views.own[4 * chosen + k], found[4 * chosen + k + 1] - views.own[4 * chosen + k + 1]));
    return Number.isFinite(far[0] + far[1]) ? `point ${chosen}: off by ${fixed(far[0])} and ${fixed(far[1])} px`
      : `point ${chosen} is not seen in all four pictures`;
  };
  /** @param {Moment} moment @param {Float64Array} found @param {boolean} goal @param {import("../engine/affine.js").Line[]} epipolar */
  const drawSpace = ({views, theta, thetaDemo}, found, goal, epipolar) => {
    if (!space) return;
    const {demonstrator, learner} = world.arms, N = world.body.length, each = Array.from({length: N}, (_, i) => i);
    const points = {demonstrator: triples(demonstrator.points(thetaDemo, world.body)), learner: triples(learner.points(theta, world.body))};
    const plates = scene.cameras.map((camera, k) => each.map(i => {
      const images = k < 2 ? views.demo : views.own, seen = k < 2 ? views.demoSeen : views.ownSeen, side = k & 1;
      return seen[2 * i + side] ? vector(backProject(camera, images[4 * i + 2 * side], images[4 * i + 2 * side + 1], PLATE_M * scene.stage.size)) : null;
    }));
    space.show({
      points, plates, rays: $("rays").checked,
      frames: {demonstrator: demonstrator.linkFrames(thetaDemo), learner: learner.linkFrames(theta)},
      ghost: goal ? learner.linkFrames(thetaDemo) : null,
      recovered: each.map(i => Number.isFinite(found[4 * i]) ? vector(triangulate(world.pairs.learner, found.subarray(4 * i, 4 * i + 4))) : null),
      lines: [
        ...scene.cameras.map((camera, k) => {
          const who = k < 2 ? "demonstrator" : "learner";
          return /** @type {[Vector, Vector, string, number, number]} */ ([vector(camera.centre), points[who][chosen], who, 1.6, .8]);
        }),
        ...rayOf(points.demonstrator[chosen]),
        ...epipolar.filter(({from}) => from === 0).flatMap(plated),
      ],
    });
  };

  /** The left camera's ray on past the point: anything on it looks the same to that camera. @param {Vector} point @returns {[Vector, Vector, string, number, number][]} */
  const rayOf = point => {
    const {centre} = scene.cameras[0];
    const on = (/** @type {number} */ share) => vector(centre.map((c, i) => c + share * (point[i] - c)));
    return [[on(.3), on(1.5), "chosen", 2.6, .9]];
  };
  /** An epipolar line, where it crosses the plate of its picture in the scene. @param {import("../engine/affine.js").Line} line @returns {[Vector, Vector, string, number, number][]} */
  const plated = ({into, a, b, c}) => {
    const camera = scene.cameras[into], {width, height} = camera, at = (/** @type {number} */ x, /** @type {number} */ y) => vector(backProject(camera, x, y, PLATE_M * scene.stage.size));
    const inside = [[0, -c / b], [width, -(c + a * width) / b], [-c / a, 0], [-(c + b * height) / a, height]]
      .filter(([x, y]) => x >= 0 && x <= width && y >= 0 && y <= height);
    return inside.length < 2 ? [] : [[at(inside[0][0], inside[0][1]), at(inside[1][0], inside[1][1]), "chosen", 2.4, .9]];
  };

  // Hands

  /** @param {"demonstrator" | "learner"} who @param {(theta: number[]) => number[]} seen @param {number[]} target */
  const reach = (who, seen, target) => {
    const from = who === "learner" ? session.now.theta : session.now.thetaDemo, theta = reachFor(seen, target, from, scene.lower, scene.upper);
    if (who === "learner") place(theta);
    else pose(theta);
  };
  draggable($("images"), event => {
    const hit = images.hit(event, session.now);
    if (!hit || event.pointerType === "touch" && hit.point !== chosen) return null; // a tap chooses, and a swipe scrolls
    chosen = hit.point;
    redraw();
    const who = hit.view < 2 ? "demonstrator" : "learner", camera = scene.cameras[hit.view], point = [world.body[hit.point]];
    const seen = (/** @type {number[]} */ theta) => projectPoint(camera, world.arms[who].points(theta, point)).slice(0, 2);
    const grip = images.under(event, hit.view).map((v, k) => v - seen(who === "learner" ? session.now.theta : session.now.thetaDemo)[k]);
    let hasMoved = false;
    return moved => {
      if (!hasMoved && Math.hypot(moved.clientX - event.clientX, moved.clientY - event.clientY) < 4) return;
      hasMoved = true;
      reach(who, seen, images.under(moved, hit.view).map((v, k) => v - grip[k]));
    };
  }, hold);
  $("images").addEventListener("click", (/** @type {PointerEvent} */ event) => {
    const hit = event.pointerType === "touch" ? images.hit(event, session.now) : null;
    if (hit) choose(hit.point);
  });
  draggable($("map"), event => {
    const box = $("map").getBoundingClientRect(), at = (/** @type {PointerEvent} */ {clientX, clientY}) => [(clientX - box.left) / map.unit, (clientY - box.top) / map.unit];
    const from = at(event), away = (/** @type {number[]} */ theta) => Math.hypot(...map.place(theta).map((v, k) => v - from[k]));
    const posture = (/** @type {PointerEvent} */ moved) => { const [x, y] = at(moved); return map.posture(x, y); };
    const near = event.pointerType === "touch" ? FINGER_PX : 16, isOwn = away(session.now.theta) < near;
    const isDemo = away(session.now.thetaDemo) < near && away(session.now.theta) > 12;
    $("map").focus({preventScroll: true});
    if (event.pointerType === "touch" && !isDemo && !isOwn) return null; // a tap places the learner, a swipe scrolls
    if (!isDemo) place(posture(event));
    return moved => isDemo ? pose(posture(moved)) : place(posture(moved));
  }, hold);
  $("map").addEventListener("click", (/** @type {PointerEvent} */ event) => {
    const box = $("map").getBoundingClientRect();
    if (event.pointerType === "touch") place(map.posture((event.clientX - box.left) / map.unit, (event.clientY - box.top) / map.unit));
  });
  $("map").addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const turns = {ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1]}[event.key];
    if (!turns) return;
    event.preventDefault();
    event.stopPropagation();
    place(session.now.theta.map((v, k) => Math.min(scene.upper[k], Math.max(scene.lower[k], v + turns[k] * (event.shiftKey ? 5 : 1) * DEGREE))));
  });
  if (space) {
    /** What can be gripped: the hand, and each link's origin that a joint moves. @param {PointerEvent} event */
    const gripped = event => {
      const box = $("space").getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      let best = null, least = GRIP_PX;
      for (const who of /** @type {const} */ (["demonstrator", "learner"])) {
        const links = scene.links.map(({on}, link) => ({on, link})).filter(({on}) => on > 0), hand = links[links.length - 1].link;
        const seen = (/** @type {number} */ link) => (/** @type {number[]} */ theta) =>
          space.project(transform(world.arms[who].linkFrames(theta)[link], link === hand ? HAND_OFFSET : [0, 0, 0])).slice(0, 2);
        for (const {link} of links) {
          const at = seen(link)(who === "learner" ? session.now.theta : session.now.thetaDemo), away = Math.hypot(at[0] - x, at[1] - y) - (link === hand ? 8 : 0);
          if (away < least) [least, best] = [away, {who, seen: seen(link), grip: [x - at[0], y - at[1]], box}];
        }
      }
      return best;
    };
    draggable($("space"), event => {
      const hit = event.shiftKey ? null : gripped(event);
      return hit && (moved => reach(hit.who, hit.seen, [moved.clientX - hit.box.left - hit.grip[0], moved.clientY - hit.box.top - hit.grip[1]]));
    }, hold);
    $("space").addEventListener("pointermove", (/** @type {PointerEvent} */ event) => { if (!event.buttons) $("space").classList.toggle("over", Boolean(gripped(event))); });
    $("space").addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
      const turns = {ArrowUp: [0, 20], ArrowDown: [0, -20], ArrowRight: [-20, 0], ArrowLeft: [20, 0]}[event.key];
      if (turns) space.turn(turns[0], turns[1]);
      else if (event.key === "+" || event.key === "-") space.zoom(event.key === "+" ? .9 : 1.1);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  // The form

  for (const preset of data.presets) $("preset").add(new Option(preset.title, preset.name));
  radios($("servo"), "servo", SERVO_WORDS, servo => {
    state.servo = servo;
    glide = null;
    posedAt = 0;
    session.begin({...session.settings, demonstrator: session.now.thetaDemo, servo});
    fillForm();
    if (playing) wake();
    redraw();
    remember();
  });
  radios($("transfer"), "transfer", TRANSFER_WORDS, transfer => restart({transfer}));
  /** What differs from the preset, in words. */
  const changed = () => {
    const usual = preset(), {points, servo, transfer, noisePx, missing} = state, differs = [
      points !== usual.points && `${points} points`, servo !== usual.servo && `law “${SERVO_WORDS[servo].title}”`,
      transfer !== usual.transfer && `transfer “${TRANSFER_WORDS[transfer].title}”`,
      noisePx !== usual.noisePx && `noise of ${fixed(noisePx)} px`, missing !== usual.missing && `${fixed(100 * missing, 0)} % of the points lost`,
    ].filter(Boolean);
    return differs.length ? `The same scene, but with ${differs.join(", ")}.` : "";
  };
  const fillForm = () => {
    for (const [name, value, words] of /** @type {const} */ ([["servo", state.servo, SERVO_WORDS], ["transfer", state.transfer, TRANSFER_WORDS]])) {
      const input = document.querySelector(`input[name=${name}][value=${value}]`);
      if (input instanceof HTMLInputElement) input.checked = true;
      say($(`${name}-says`), words[value].says);
    }
    say($("says"), misread.length ? `This link asks for what the lab does not have: ${misread.join(", ")}.` : changed() || preset().says);
    $("noise").value = state.noisePx;
    $("lost").value = 100 * state.missing;
    if (Number($("seed").value) !== state.seed || !$("seed").value) $("seed").value = state.seed;
    say($("noise").nextElementSibling, `${fixed(state.noisePx)} px`);
    say($("lost").nextElementSibling, `${(100 * state.missing).toFixed(0)} %`);
    $("points").replaceChildren(...Object.keys(scene.layouts).map(count => new Option(count, count)));
    $("points").value = state.points;
    for (const id of ["noise", "lost"]) $(id).style.setProperty("--at", `${100 * $(id).value / $(id).max}%`);
  };
  $("preset").addEventListener("change", () => {
    const chosenOne = data.presets[$("preset").selectedIndex];
    play(false);
    misread = [];
    enter(beginning(chosenOne, data.scenes[chosenOne.scene]));
    remember();
  });
  $("noise").addEventListener("input", () => restart({noisePx: Number($("noise").value)}));
  $("lost").addEventListener("input", () => restart({missing: Number($("lost").value) / 100}));
  $("seed").addEventListener("input", () => { if ($("seed").value && $("seed").validity.valid) restart({seed: Number($("seed").value)}); });
  $("seed").addEventListener("change", fillForm);
  $("points").addEventListener("change", () => restart({points: Number($("points").value)}));
  for (const id of ["goal", "rays"]) $(id).addEventListener("change", redraw);
  $("play").addEventListener("click", () => play(!playing));
  $("step").addEventListener("click", step);
  $("undo").addEventListener("click", undo);
  $("reset").addEventListener("click", reset);
  $("help").addEventListener("click", () => $("keys").showModal());
  $("fit").addEventListener("click", () => space?.fit());
  const recolour = () => {
    const root = document.documentElement.dataset;
    root.scheme = root.scheme === "dark" ? "light" : "dark";
    space?.recolour();
    if (shownLandscape) showMap(shownLandscape);
    redraw();
  };
  $("scheme").addEventListener("click", recolour);
  $("link").addEventListener("click", async () => {
    const address = location.href.split("#")[0] + toAddress(current(), preset(), scene);
    say($("link"), "Copying");
    const isLate = new Promise((_, refuse) => setTimeout(refuse, COPY_MS));
    try {
      await Promise.race([navigator.clipboard.writeText(address), isLate]);
      say($("link"), "Copied");
    } catch {
      prompt("The link to what this page shows:", address);
    }
    setTimeout(() => say($("link"), "Copy link"), 1500);
  });
  const choose = (/** @type {number} */ point) => {
    if (point >= world.body.length) return;
    chosen = point;
    redraw();
  };
  const toggle = (/** @type {string} */ id) => { $(id).checked = !$(id).checked; redraw(); };
  const nextPreset = () => {
    $("preset").selectedIndex = ($("preset").selectedIndex + 1) % $("preset").length;
    $("preset").dispatchEvent(new Event("change"));
  };
  /** @type {Record<string, () => void>} */
  const KEYS = {
    " ": () => play(!playing), ArrowRight: step, ArrowLeft: undo, r: reset, g: () => toggle("goal"), n: () => choose((chosen + 1) % world.body.length),
    p: nextPreset, v: () => space?.fit(), d: recolour, "?": () => $("keys").showModal(),
  };
  for (let digit = 0; digit < 10; digit++) KEYS[digit] = () => choose(digit);
  document.addEventListener("keydown", event => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, {target} = event;
    if (event.ctrlKey || event.metaKey || event.altKey || !(key in KEYS) || !(target instanceof Element)) return;
    if (target.matches("select, input[type=number]") || document.querySelector("dialog[open]")) return;
    if (target.matches("input") && key.startsWith("Arrow") || key === " " && target.matches("button, summary, input[type=checkbox]")) return;
    event.preventDefault();
    KEYS[key]();
  });
  addEventListener("hashchange", () => {
    misread = [];
    enter(fromAddress(location.hash, data.presets, data.scenes, misread));
    remember();
  });
  new ResizeObserver(() => {
    if (shownLandscape) showMap(shownLandscape);
    redraw();
  }).observe($("map"));
  for (const drawing of /** @type {const} */ ([[images, $("images")], [curve, $("curve")]]))
    new ResizeObserver(() => { drawing[0].measure(); redraw(); }).observe(drawing[1]);

  for (const [name, element] of /** @type {[string, Element | null][]} */ ([["--head", document.querySelector("header")], ["--foot", document.querySelector(".bar")]]))
    if (element) new ResizeObserver(() => document.documentElement.style.setProperty(name, `${element.clientHeight}px`)).observe(element);
  images.measure();
  curve.measure();
  enter(state);
  draw();
  $("open").hidden = !isServed;
  if (isServed || misread.length) remember();
  const fineMap = () => {
    const fine = landscapeOf(FINE_DEG);
    fine.evaluate(state.transfer, demoLook());
    showMap(fine);
  };
  const linkOfPage = () => pageLink(current(), scene.page.scene, scene.page.layouts);
  Object.assign(globalThis, {lab: {pageLink: linkOfPage, fineMap, session: () => session, world: () => world, landscape: () => shownLandscape, pose, place, step, draw, space, images, map, drawnAt: performance.now()}});
}

/** The 3-D view, or null with a word on it. @param {Data} data @param {ArrayBuffer} meshes */
function opened(data, meshes) {
  let space = null;
  try { space = openSpace($("space"), $("labels"), data.robot, meshes); } catch (error) { console.warn(error); }
  if (!space) {
    document.body.classList.add("flat");
    say($("labels"), "This browser draws no WebGL: everything but the 3-D view is here.");
  }
  return space;
}

/** @param {HTMLElement} box @param {string} name @param {Record<string, {title: string}>} words @param {(value: string) => void} chosen */
function radios(box, name, words, chosen) {
  for (const [value, {title}] of Object.entries(words)) {
    const label = box.appendChild(document.createElement("label"));
    label.innerHTML = `<input type="radio" name="${name}" value="${value}"><span>${title}</span>`;
    label.querySelector("input")?.addEventListener("change", () => chosen(value));
  }
}

/** The point that shows most: with the largest residual. @param {Moment} moment */
function farthestOff({views, usable, fitted}) {
  if (!fitted) return 0;
  const own = select(views.own, usable), found = fitted.recover(select(views.demo, usable));
  const off = usable.map((_, k) => Math.hypot(...[0, 1, 2, 3].map(c => own[4 * k + c] - found[4 * k + c])));
  return usable[off.indexOf(Math.max(...off))];
}

/** Whether two postures are equal, but for rounding. @param {number[]} a @param {number[]} b */
const same = (a, b) => a.every((v, k) => Math.abs(v - b[k]) < 1e-6);
/** @param {ArrayLike<number>} p @returns {import("./space.js").Vector} */
const vector = p => [p[0], p[1], p[2]];
/** @param {Float64Array} points (3 N) */
const triples = points => Array.from({length: points.length / 3}, (_, i) => vector(points.subarray(3 * i, 3 * i + 3)));

if (typeof DecompressionStream === "undefined") fault("The lab needs a browser of 2023 or later.");
else Promise.all([unpacked("data").json(), unpacked("meshes").arrayBuffer()]).then(([data, meshes]) => begin(data, meshes))
  .catch(error => { fault(`This page is damaged: ${error.message}`); throw error; });
