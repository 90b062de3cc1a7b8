/** Lessons: which screen is shown, what the keys do, and what others may ask of the page.
 * @import {Lesson, Step, Mark, Answer, Page, Round} from "./stage.js" @import {KeptStep} from "./store.js" @import {Given} from "./questions.js" @import {Screen, Course} from "./step-screen.js"
 * @typedef {Page & {lessons: Lesson[], start?: string, catalogue?: {name: string, title:
 * string, short: string, about: string, afterwards: string, minutes: number, here: boolean}[]}} Data catalogue: all
 * lessons that are served, those here and others
 * @typedef {{kind: "home"} | {kind: "step", id: string} | {kind: "before" | "after", k: number} | {kind: "end"}}
 * Place
 * @typedef {Object} Shown what a page shows, for others to follow
 * @property {string} lesson
 * @property {string} step the screen, as addresses name it
 * @property {number} seed
 * @property {boolean} revealed
 * @property {[string, number][]} sliders
 * @property {Mark | null} mark
 * @property {Answer} answer
 * @property {Round[]} rounds
 * @property {number[]} theta of the learner; empty without a step
 * @property {{theta: number[], E: number, probe: boolean}[]} motions the latest
 * @property {number} reveal 0 … 1
 * @property {number} run
 * @typedef {{counts: number[]} | {marks: Mark[]} | null} Others what a class has answered: how often each answer was
 * given, or where marks were made */
import {isAnswered, isRight, roundsOf} from "./answers.js";
import {inline, make, plain} from "./dom.js";
import {labAddress, viewimitAddress} from "./elsewhere.js";
import {FIGURES} from "./figures/registry.js";
import {grade} from "./measures.js";
import {printable} from "./paper.js";
import {QUESTION_S} from "./questions.js";
import {Cover} from "./cover.js";
import {EndScreen, QuestionScreen} from "./screens.js";
import {Stage} from "./stage.js";
import {StepScreen} from "./step-screen.js";
import {Store} from "./store.js";
import {isForPage} from "../view/keys.js";
import {byId as $, fault, perFrame, unpacked} from "../view/page.js";

const WORDS_A_MINUTE = 200, LOOKING_S = 25, ACTING_S = 50, ROUND_S = 15; // of a step: to estimate the time that is left
const FIRST_SEEDS = 97, MAX_SHARED = 60; // motions that others are sent

/** How long a step takes, before all steps are scaled to the lesson's minutes. @param {Step} step */
function secondsOf(step) {
  const {text, ask, say, after = "", play} = step,
    words = `${text} ${ask.question} ${say} ${after}`.split(/\s+/).length;
  return words / WORDS_A_MINUTE * 60 + (["do", "predict", "pose"].includes(ask.kind) ? ACTING_S : LOOKING_S)
    + (play ?? 0) + ROUND_S * (roundsOf(ask) - 1);
}

/** Finished rounds, except the last. @param {Stage} stage */
const roundsMade = ({step, rounds, run}) =>
  Math.min(roundsOf(step.ask) - 1, step.ask.kind === "bet" ? run : rounds.length);

/** @param {Data} data */
function begin(data) {
  const store = new Store();
  let lesson = data.lessons[0];
  /** @type {Place} */
  let place = {kind: "home"};
  let stages = /** @type {Map<string, Stage>} */ (new Map());
  let seeds = /** @type {Map<string, number>} */ (new Map()); // that the address or a button has asked for
  let screen = /** @type {Screen | null} */ (null);
  let stage = /** @type {Stage | null} */ (null); // of the step on display
  let others = /** @type {Others} */ (null);
  /** @type {{lesson: Lesson, place: Place, seeds: Map<string, number>} | null} the place before the lesson was
   * suspended */
  let before = null;
  let isFrozen = false, isLed = false, isHeld = false, isTruthHidden = false, isArriving = false;
  const redraw = perFrame(draw);
  const isAlone = (data.catalogue ?? data.lessons).length < 2;
  const isLocked = () => isFrozen || isLed, kept = () => store.of(lesson.name);

  /** The state of viewimit's page that one came from, as its links have it. */
  const instrument = new URLSearchParams(location.hash.slice(1)).get("page") ?? "";  // a query of viewimit's page
  /** The address of another lesson, which leads back to the same state. @param {string} name @param {string[]} parts */
  const beside = (name, ...parts) => {
    const fragment = [...parts, ...instrument ? [`page=${encodeURIComponent(instrument)}`] : []].join("&");
    return fragment ? `${name}#${fragment}` : name;
  };
  /** Whether the lab stands beside this page. */
  const isServed = location.protocol !== "file:" && /\/lab\/[^/]+$/.test(location.pathname);

  // Places and their names

  /** @param {Lesson} of @returns {Place[]} */
  const placesOf = of => {
    const questions = (of.questions ?? []).map((_, k) => k);
    return [...questions.map(k => /** @type {Place} */ ({kind: "before", k})),
      ...of.steps.map(({id}) => /** @type {Place} */ ({kind: "step", id})),
      ...questions.map(k => /** @type {Place} */ ({kind: "after", k})), {kind: "end"}];
  };
  const nameOf = (/** @type {Place} */ of) => of.kind === "step" ? of.id : of.kind === "home" || of.kind === "end"
    ? of.kind : `${of.kind}-${of.k + 1}`;
  /** @param {Lesson} of @param {string} name @returns {Place} */
  const placeOf = (of, name) => placesOf(of).find(one => nameOf(one) === name) ?? {kind: "home"};
  const stepAt = () => lesson.steps.findIndex(({id}) => place.kind === "step" && id === place.id);
  const index = () => placesOf(lesson).findIndex(one => nameOf(one) === nameOf(place));

  /** @param {Lesson} next @param {Place} to @param {number} [seed] of the random state */
  function enter(next, to, seed) {
    if (next !== lesson) {
      stages = new Map();
      seeds = new Map();
    }
    lesson = next;
    place = to;
    if (seed && to.kind === "step") setSeed(to.id, seed);
    show();
    remember();
    hooks.onStep(nameOf(to));
    hooks.onChange();
  }

  /** @param {number} by */
  function go(by) {
    if (isLocked()) return;
    const all = placesOf(lesson), at = index() + by;
    if (at < 0) enter(lesson, {kind: "home"});
    else if (at in all) enter(lesson, all[at]);
  }

  /** @param {string} id @param {number} seed */
  function setSeed(id, seed) {
    const step = lesson.steps.find(one => one.id === id), source = step?.carry && !step.randomise ? step.carry : id;
    seeds.set(source, seed);
    if (stages.get(source)?.seed !== seed) stages.delete(source);
    if (kept().steps[source] && kept().steps[source].seed !== seed) forget(source);
    stages.delete(id);
  }

  /** A step, and those that go on from it, as if they were new. @param {string} id */
  function forget(id) {
    delete kept().steps[id];
    stages.delete(id);
    for (const {id: later, carry} of lesson.steps) if (carry === id) forget(later);
  }

  /** @param {string} id @returns {Stage} */
  function stageOf(id) {
    const known = stages.get(id), step = /** @type {Step} */ (lesson.steps.find(one => one.id === id)),
      was = kept().steps[id];
    const previous = step.carry && lesson.steps.some(one => one.id === step.carry) ? stageOf(step.carry) : null;
    if (known && known.previous === previous && known.carried === previous?.motions) return known;
    const made = new Stage(data, step, {seed: seeds.get(id) ?? was?.seed ?? kept().person % FIRST_SEEDS + 1, previous});
    made.unit = FIGURES[step.ask.figure ?? ""]?.unit ?? "px";
    made.truthHidden = isTruthHidden;
    if (was) recall(made, was);
    stages.set(id, made);
    return made;
  }

  /** @param {Stage} made @param {KeptStep} was */
  function recall(made, was) {
    made.answer = was.answer ?? {};
    made.mark = was.mark ?? null;
    made.rounds = was.rounds ?? [];
    made.reveal = was.revealed ? 1 : 0;
    made.bets = was.bets ?? [];
    made.run = was.run ?? 0;
    made.graded = was.graded ? Object.fromEntries(Object.entries(was.graded).map(([name, one]) =>
      [name, {...one, value: one.value ?? NaN}])) : null; // JSON has no NaN
    for (const [name, value] of was.sliders ?? []) if (made.sliders.has(name)
      && !name.startsWith("knob ")) made.slide(name, value);
    if (was.motions?.length > 1 && !made.previous) {
      made.motions = was.motions;
      made.observe(was.motions[was.motions.length - 1].theta);
    }
    if (was.revealed && made.step.meets) made.observe(made.moment.thetaDemo);
    if (was.revealed) made.graded ??= grade(made);
  }

  function keep() {
    if (!stage) return;
    const {answer, mark, seed, motions, rounds, step, previous, run, bets, graded} = stage;
    kept().steps[step.id] = {answer, mark, seed, revealed: stage.isRevealed && stage.run + 1 >= stage.runs,
      right: stage.isRevealed ? isRight(stage) : null, run, bets, graded,
      motions: previous || motions.length < 2 ? [] : motions, rounds, sliders: [...stage.sliders]};
    store.save(lesson.name);
    hooks.onChange();
  }

  /** The step from its start. @param {number} seed */
  function restart(seed) {
    if (!stage) return;
    forget(stage.step.id);
    seeds.set(stage.step.id, seed);
    store.save(lesson.name);
    show();
    remember();
    hooks.onChange();
  }

  const isRandom = (/** @type {Stage} */ {step, previous}) =>
    Boolean(step.randomise || previous?.step.randomise || step.ask.kind === "predict");
  /** The address of what is shown: a further entry for another screen, so that the browser's Back leads one back. */
  function remember() {
    const parts = [`lesson=${lesson.name}`];
    if (place.kind !== "home") parts.push(`step=${nameOf(place)}`);
    if (stage && isRandom(stage)) parts.push(`seed=${stage.seed}`);
    if (instrument) parts.push(`page=${encodeURIComponent(instrument)}`);
    const was = new URLSearchParams(location.hash.slice(1)), isOther = !isArriving && !isLocked()
      && (was.get("lesson") !== lesson.name || (was.get("step") ?? "home") !== nameOf(place));
    try {
      history[isOther ? "pushState" : "replaceState"](null, "", `#${parts.join("&")}`);
    } catch { /* a frame without an address */ }
  }

  // Screens

  /** What the page around a step does for it. @type {Course} */
  const course = {
    isLocked, isHeld: () => isHeld, keep, go, note, announce, restart, redraw,
    answered: answered => hooks.onAnswer(answered.step.id, hooks.answer() ?? {}, isRight(answered)),
    others: () => others && "counts" in others ? others : null,
    links: now => {
      if (!isServed) return [];
      const lab = labAddress(now, location.pathname.split("/").pop() + location.hash), viewimit = viewimitAddress(now);
      return [...lab ? [{of: "lab", href: `../lab${lab}`, words: "Open in the lab"}] : [],
        ...instrument ? [{of: "viewimit", href: `../?${instrument}`, words: "Back to viewimit"}]
          : viewimit ? [{of: "viewimit", href: `../${viewimit}`, words: "Open in viewimit"}] : []];
    },
  };

  function show() {
    screen?.remove();
    announce("");
    note("");
    $("body").scrollTop = $("figures").scrollTop = 0;
    $("figures").replaceChildren();
    stage = place.kind === "step" ? stageOf(place.id) : null;
    $("figures").tabIndex = place.kind === "end" ? 0 : -1;
    document.body.dataset.screen = place.kind;
    document.body.dataset.ask = stage?.step.ask.kind ?? "";
    if (stage) {
      stage.others = others && "marks" in others ? others.marks : [];
      screen = new StepScreen($("body"), $("figures"), stage, course);
    } else if (place.kind === "before" || place.kind === "after") {
      const {kind} = place;
      screen = new QuestionScreen($("body"), lesson, kind, place.k, kept(), {
        keep: (id, given) => {
          kept()[kind][id] = given;
          store.save(lesson.name);
          hooks.onQuestion(kind, id, given);
        },
        go, redraw, skipAll: () => enter(lesson, kind === "before" ? placeOf(lesson, lesson.steps[0].id)
          : {kind: "end"}),
      });
    } else if (place.kind === "end") screen = new EndScreen($("body"), $("figures"), lesson, kept(), linkTo,
      following(), {words: isAlone ? "Back to the cover" : "All lessons", key: "↵", filled: true, act: () => enter(lesson, {kind: "home"})});
    else screen = new Cover($("body"), data.lessons, lesson, progressOf, {
      start: one => enter(one, nextOf(one)), steps: one => enter(one, placeOf(one, one.steps[0].id)),
        step: (one, id) => enter(one, {kind: "step", id}),
      end: one => enter(one, {kind: "end"}),
      forget: one => {
        store.forget(one.name);
        stages = new Map();
        show();
      }, catalogue: (data.catalogue ?? []).filter(({here}) => !here), beside,
    });
    $("heading").textContent = lesson.title;
    document.title = `${stage ? stage.step.title : lesson.title} · ${lesson.short}`;
    draw();
    const heading = /** @type {HTMLElement | null} */ ($("body").querySelector("h2"));
    heading?.focus({preventScroll: true});
  }

  /** Where somebody goes on. @param {Lesson} of @returns {Place} */
  function nextOf(of) {
    const {steps} = store.of(of.name), open = of.steps.find(({id}) => !steps[id]?.revealed);
    const first = openQuestion(of, "before"), last = openQuestion(of, "after");
    if (first >= 0 && !Object.keys(steps).length) return {kind: "before", k: first};
    return open ? {kind: "step", id: open.id} : last >= 0 ? {kind: "after", k: last} : {kind: "end"};
  }
  /** The first of the questions that is not answered; -1 for none.
   * @param {Lesson} of @param {"before" | "after"} phase */
  const openQuestion = ({name, questions}, phase) => (questions ?? []).findIndex(({id}) => !store.of(name)[phase][id]);
  /** @param {Lesson} of */
  function progressOf(of) {
    const {steps} = store.of(of.name), done = of.steps.filter(({id}) => steps[id]?.revealed).length;
    const isAsked = done === of.steps.length && openQuestion(of, "after") >= 0;
    return {done, isAsked, words: done === 0 ? "Start" : done < of.steps.length ? "Continue"
      : isAsked ? "Go on with the questions" : "See the end"};
  }

  /** A step that this page has, or that is served beside it; null for another.
   * @param {string} target "lesson/step" */
  function linkTo(target) {
    const [name, id] = target.split("/"), found = data.lessons.find(one => one.name === name),
      at = found?.steps.findIndex(step => step.id === id) ?? -1;
    if (found && at >= 0) return {words: `${found.short} ${at + 1} →`, href: null, go: () =>
      enter(found, {kind: "step", id})};
    const other = data.catalogue?.find(one => one.name === name && !one.here);
    return other ? {words: `${other.short}: ${id.replaceAll("-", " ")} →`, go: null,
      href: beside(name, `lesson=${name}`, `step=${id}`)} : null;
  }

  /** The lesson that comes after this one, here or beside this page; null for none. */
  function following() {
    const all = data.catalogue ?? data.lessons.map(one => ({...one, here: true}));
    const next = all[all.findIndex(({name}) => name === lesson.name) + 1];
    if (!next || !all.some(({name}) => name === lesson.name)) return null;
    const found = data.lessons.find(({name}) => name === next.name);
    return {words: `Next lesson: ${next.title} →`, href: found ? null : beside(next.name), go: found ? () =>
      enter(found, {kind: "home"}) : null};
  }

  // Drawing

  function draw() {
    screen?.draw();
    drawHead();
    drawFoot();
    document.body.classList.toggle("locked", isLocked());
  }

  function drawHead() {
    const steps = lesson.steps, at = stepAt();
    const where = place.kind === "step" ? `${at + 1} of ${steps.length}` : place.kind === "before"
      ? `Question ${place.k + 1} of ${lesson.questions?.length}, before`
      : place.kind === "after" ? `Question ${place.k + 1} of ${lesson.questions?.length}, after`
        : place.kind === "end" ? "Done" : "";
    $("home").textContent = place.kind === "home" ? "viewimit lessons" : lesson.short;
    $("where").textContent = where;
    $("left").textContent = left();
    $("home").title = isAlone ? "The cover" : "All lessons";
    $("leave").hidden = place.kind === "home" && !isServed;
    $("leave").firstElementChild.textContent = place.kind !== "home" ? "Leave" : instrument ? "Back to viewimit"
      : "The lab";
    const key = JSON.stringify([lesson.name, nameOf(place), steps.map(({id}) => kept().steps[id]?.revealed ?? false),
      isLocked()]);
    if ($("progress").dataset.key === key) return;
    $("progress").dataset.key = key;
    $("progress").hidden = place.kind === "home";
    $("progress").replaceChildren(...steps.map((step, k) => {
      const isDone = kept().steps[step.id]?.revealed ?? false, isHere = k === at;
      return make("button", {type: "button", class: `${isDone ? "done" : ""}${isHere ? " here" : ""}`,
        title: `${k + 1}  ${plain(step.title)}`, disabled: isLocked(), "aria-current": isHere ? "step" : null,
        "aria-label": `Step ${k + 1}: ${plain(step.title)}${isDone ? ", done" : ""}`, onclick: () =>
          enter(lesson, {kind: "step", id: step.id})}, make("i", {}));
    }));
  }

  /** How long the rest takes: each step has the share of its words and rounds, and so have the questions. */
  function left() {
    if (place.kind === "home" || place.kind === "end") return "";
    const {steps} = lesson, all = steps.reduce((sum, step) => sum + secondsOf(step), 0);
    const at = place.kind === "step" ? stepAt() : place.kind === "before" ? 0 : steps.length;
    const open = steps.slice(at).filter(({id}) => !kept().steps[id]?.revealed).reduce((sum, step) =>
      sum + secondsOf(step) - (step.id === stage?.step.id ? roundsMade(stage) * ROUND_S : 0), 0);
    const count = lesson.questions?.length ?? 0, asked = place.kind === "before" ? 2 * count - place.k
      : place.kind === "after" ? count - place.k : count;
    const minutes = Math.round((60 * lesson.minutes * open / all + QUESTION_S * asked) / 60);
    return minutes >= 1 ? `${minutes} min left` : "";
  }

  function drawFoot() {
    const {words, key, filled, disabled} = screen?.primary() ?? {words: ""}, skip = screen?.skip()
      ?? null, isHome = place.kind === "home";
    const now = JSON.stringify([words, key, filled, disabled, skip?.words, skip?.disabled, isHome, isLocked()]);
    if ($("foot").dataset.key === now && $("foot").childElementCount) return;
    $("foot").dataset.key = now;
    const hadFocus = $("foot").contains(document.activeElement)
      && document.activeElement?.classList.contains("primary");
    const back = make("button", {type: "button", class: "plain back", disabled: isLocked(), "aria-label": "Back",
      onclick: () => go(-1)}, make("kbd", {}, "←"), make("span", {}, "Back"));
    const primary = make("button", {type: "button", class: `primary ${filled ? "filled" : "plain"}`, disabled,
      onclick: () => { screen?.primary().act(); drawFoot(); }}, words, key ? make("kbd", {}, key) : null);
    $("foot").replaceChildren(...isHome ? [] : [back], ...skip
      ? [make("button", {type: "button", class: "text", disabled: skip.disabled, onclick: () => screen?.skip()?.act()}, skip.words)]
      : [], ...isHome ? [] : [primary]);
    if (hadFocus) primary.focus({preventScroll: true});
  }

  function note(/** @type {string} */ words) {
    $("note").textContent = words;
    $("note").hidden = !words;
  }
  let announcing = 0;
  function announce(/** @type {string} */ words) {
    clearTimeout(announcing);
    announcing = setTimeout(() => { $("announced").textContent = words; }, 150);
  }

  // Others

  /** @param {Shown} shown */
  function follow(shown) {
    const now = hooks.state();
    if (now.lesson !== shown.lesson || now.step !== shown.step || now.seed !== shown.seed) hooks.goTo(shown.lesson,
      shown.step, shown.seed);
    else if (now.revealed && !shown.revealed) restart(shown.seed);
    if (!stage) return;
    const {moment} = stage;
    Object.assign(stage, {mark: shown.mark, answer: shown.answer, rounds: shown.rounds, run: shown.run});
    for (const [name, value] of shown.sliders) if (stage.sliders.get(name) !== value) stage.slide(name, value);
    if (shown.motions.length > 1 && !stage.previous) stage.motions = shown.motions;
    if (shown.theta.length && shown.theta.some((v, k) => v !== moment.theta[k])) stage.observe(shown.theta);
    if (shown.revealed && !stage.isRevealed) hooks.reveal();
    redraw();
  }

  const hooks = {
    /** Called with every answer.
     * @type {(step: string, answer: Answer & {place?: Mark}, right: boolean | null) => void} */
    onAnswer: () => {},
    /** Called at every screen. @type {(step: string) => void} */
    onStep: () => {},
    /** @type {(phase: "before" | "after", item: string, given: Given) => void} */
    onQuestion: () => {},
    /** Called after anything that `state` or `summary` tells. @type {() => void} */
    onChange: () => {},
    /** Called when the key T has hidden or shown what the learner cannot know. @type {(hidden: boolean) => void} */
    onTruth: () => {},
    /** In the card, above its buttons: stays empty without others. @type {HTMLElement} */
    box: $("box"),
    /** In the head line. @type {HTMLElement} */
    head: $("head"),
    data,
    /** Suspend answers and place, and go on with a copy that is not kept. */
    suspend() {
      if (store.suspended) return;
      keep();
      store.suspend();
      before = {lesson, place, seeds: new Map(seeds)};
    },
    /** Bring back the suspended answers and place. */
    back() {
      if (!store.suspended || !before) return;
      store.putBack();
      stages = new Map();
      const {lesson: name, place: at, seeds: earlier} = before;
      before = null;
      lesson = name;
      seeds = earlier;
      enter(name, at);
    },
    /** @param {string} name @param {string} step @param {number} [seed] */
    goTo(name, step, seed) {
      const found = data.lessons.find(one => one.name === name);
      if (found) enter(found, placeOf(found, step), seed);
      return Boolean(found);
    },
    /** Lock all buttons. @param {boolean} on */
    freeze(on) {
      isFrozen = on;
      redraw();
    },
    /** Follow another page; null to stop. @param {Shown | null} shown */
    lead(shown) {
      isLed = Boolean(shown);
      if (shown) follow(shown);
      redraw();
    },
    /** Take answers, but leave it to others to show the right one. @param {boolean} on */
    hold(on) {
      isHeld = on;
      redraw();
    },
    /** @param {boolean} on */
    hideTruth(on) {
      isTruthHidden = on;
      for (const one of stages.values()) one.truthHidden = on;
      redraw();
    },
    /** What a class has answered. @param {Others | Mark[]} given */
    showOthers(given) {
      others = Array.isArray(given) ? {marks: given} : given;
      if (stage) stage.others = others && "marks" in others ? others.marks : [];
      redraw();
    },
    /** Show the right answer, answered or not. */
    reveal() {
      if (screen instanceof StepScreen && stage && !stage.isRevealed) screen.reveal(!isAnswered(stage));
      redraw();
    },
    /** The step as if nobody had answered it. */
    askAgain: () => { if (stage) restart(stage.seed); },
    /** @returns {Shown} */
    state: () => ({lesson: lesson.name, step: nameOf(place), seed: stage?.seed ?? 1, revealed: stage?.isRevealed
      ?? false, sliders: [...stage?.sliders ?? []], mark: stage?.mark ?? null,
      answer: stage?.answer ?? {}, rounds: stage?.rounds ?? [], theta: stage?.moment.theta ?? [],
        motions: stage?.motions.slice(-MAX_SHARED) ?? [], reveal: stage?.reveal ?? 0, run: stage?.run ?? 0}),
    /** How far one is, for a class's overview. */
    summary: () => ({lesson: lesson.name, step: nameOf(place), steps: lesson.steps.length,
      answered: Object.values(kept().steps).filter(({revealed}) => revealed).length,
      right: Object.values(kept().steps).filter(({right}) => right).length, motions: stage?.steps ?? 0, E: stage ? stage.moment.E : null}),
    /** The answer to the step on display; null for none yet. @returns {(Answer & {place?: Mark}) | null} */
    answer: () => stage && isAnswered(stage) ? {...stage.answer, ...stage.mark ? {place: stage.mark} : {}} : null,
    /** @returns {Stage | null} */
    stage: () => stage,
    lessons: () => data.lessons,
    draw,
  };

  // Hands

  const leave = () => {
    if (isLocked()) return;
    if (place.kind !== "home") enter(lesson, {kind: "home"});
    else if (isServed) location.href = instrument ? `../?${instrument}` : "../lab";
  };
  $("home").addEventListener("click", leave);
  $("leave").addEventListener("click", leave);
  const recolour = () => {
    const root = document.documentElement;
    root.dataset.scheme = root.dataset.scheme === "dark" ? "light" : "dark";
    root.dispatchEvent(new Event("recolour"));
    redraw();
  };
  $("scheme").addEventListener("click", recolour);
  /** Show what a term of the glossary means, or no longer. @param {Element | null} term */
  const explain = term => {
    if (!(term instanceof HTMLElement)) return;
    const isOpen = term.getAttribute("aria-expanded") === "true",
      holder = /** @type {HTMLElement} */ (term.closest("p, div"));
    document.querySelectorAll(".definition").forEach(one => one.remove());
    document.querySelectorAll(".term").forEach(one => one.setAttribute("aria-expanded", "false"));
    if (isOpen) return;
    term.setAttribute("aria-expanded", "true");
    holder.after(make("p", {class: "definition", role: "note",
      html: inline(data.glossary?.[term.dataset.term ?? ""] ?? "")}));
  };
  $("body").addEventListener("click", (/** @type {Event} */ event) =>
    explain(event.target instanceof Element ? event.target.closest(".term") : null));

  document.addEventListener("keydown", event => {
    if (!isForPage(event)) return;
    const {key} = event, target = /** @type {Element} */ (event.target);
    const isRange = target.matches("input[type=range]"), isButton = target.matches("button, a, summary");
    if (isRange && (key.startsWith("Arrow") || ["Home", "End", "PageUp", "PageDown"].includes(key))) return;
    if (target.matches("canvas") && key.startsWith("Arrow")) return;
    const isChosen = target.matches(".option.chosen");
    const take = () => {
      if (target.matches(".term") && (key === "Enter" || key === " ")) return explain(target);
      if (key === "Escape") return leave();
      if (!isLocked() && screen?.key(event)) return;
      if (key === "Enter" && isButton && !isChosen
        && !target.matches(".option[aria-disabled=true], #progress button")) return false;
      if (key === "Enter" || key === "ArrowRight") {
        const primary = screen?.primary();
        if (primary && !primary.disabled && (key === "Enter" ? primary.filled
          : primary.key === "→")) return primary.act();
        return key === "Enter" ? undefined : false;
      }
      if (key === "ArrowLeft" && place.kind !== "home") return go(-1);
      if (key.toLowerCase() === "d") return recolour();
      if (key.toLowerCase() === "t" && stage) {
        hooks.hideTruth(!isTruthHidden);
        return hooks.onTruth(isTruthHidden);
      }
      return false;
    };
    if (take() !== false) event.preventDefault();
  });
  const arrive = () => {
    if (isLocked()) return remember();
    isArriving = true;
    const asked = new URLSearchParams(location.hash.slice(1)),
      found = data.lessons.find(({name}) => name === (asked.get("lesson") ?? data.start)),
      seed = Number(asked.get("seed"));
    const isPlain = !asked.get("step") && !asked.get("lesson") && data.lessons.length === 1
      && !data.lessons[0].questions?.length;
    enter(found ?? data.lessons[0], isPlain ? nextOf(data.lessons[0]) : asked.get("step")
      ? placeOf(found ?? data.lessons[0], asked.get("step") ?? "") : {kind: "home"}, Number.isInteger(seed)
      && seed > 0 ? seed : undefined);
    isArriving = false;
  };
  addEventListener("hashchange", arrive);
  printable(data, () => place.kind === "home" ? data.lessons : [lesson]);
  Object.assign(globalThis, {lesson: hooks});
  arrive();
  dispatchEvent(new Event("lesson"));
  if (!store.keeps) note("This browser keeps nothing for this page: your answers are lost when you close it.");
}

if (typeof DecompressionStream === "undefined") fault("The lessons need a browser of 2023 or later.");
else unpacked("data").json().then(begin)
  .catch(error => { fault(`This page is damaged: ${error.message}`); throw error; });
