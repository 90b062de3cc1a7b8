/** A lessons' page that belongs to a class: it sends answers to the server, and follows the lecturer's orders. It is
 * the page's entry; the lessons themselves know nothing of a class.
 * @import {Message} from "./class-link.js"
 * @typedef {{total: number, counts: number[], values: number[][], right: number | null}} Tally
 * @typedef {{right: number, gained: number, lost: number, wrong: number}} Moved
 * @typedef {{now: Tally, before: Tally | null, first: Tally | null, moved: Moved | null, moved_since_first: Moved
 * | null}} Results
 * @typedef {{round: number, lesson: string, step: string, phase: "own" | "before" | "after", times: number,
 * revealed: boolean, results: Results | null, seed: number, left_out: number}} Asked
 * @typedef {{asked: Asked | null, lead: boolean, gather: {number: number, lesson: string, step: string, seed:
 * number} | null, frozen: boolean, hidden: boolean, reset: number}} Orders */
import {ClassChallenge} from "./class-challenge.js";
import {browser, Link, tab} from "./class-link.js";
import {resultsOf} from "./class-results.js";
import {Lecturer} from "./class-lecturer.js";
import {make} from "./dom.js";
import {measure} from "./measures.js";
import {} from "./lesson.js";
import {byId as $} from "../view/page.js";

const NAME = /^[\w .-]{0,60}$/, MAX_DEPTH = 6; // of a screen that another page has sent
const QUESTIONS = "questions"; // the form of the eight
const ANSWER_MS = 250, AT_MS = 1000, LEAD_MS = 100; // between two messages
const NO_IDEA = 50; // %, for a run without a bet
const MAX_POSTURES = 40, MAX_CORNERS = 200, DEGREE = Math.PI / 180;

/** @type {Orders} */
const NOTHING = {asked: null, lead: false, gather: null, frozen: false, hidden: false, reset: 0};

/** An answer as the server takes it; null for none. @param {any} answer @param {any} stage */
export function given(answer, stage) {
  if (answer.choice !== undefined) return {choice: answer.choice};
  if (answer.pose) return {posture: answer.pose};
  if (answer.number !== undefined) return {number: answer.number};
  if (answer.selected) return {values: [...answer.selected, ...answer.reason === undefined ? [] : [answer.reason]]};
  if (answer.bet !== undefined) return {values: Array.from(Object.assign([...stage.bets], {[stage.run]: answer.bet}), bet => bet ?? NO_IDEA)};
  if (stage?.rounds?.length) {
    const off = (/** @type {{mark: number[], to: number[]}} */ {mark, to}) => Math.hypot(mark[0] - to[0], mark[1] - to[1]);
    return {values: stage.rounds.map((/** @type {any} */ round) => Math.round(10 * off(round)) / 10)};
  }
  if (answer.place) return {place: answer.place};
  return answer.done ? {number: (stage?.motions.length ?? 1) - 1} : null;
}

/** Whether a screen of another page holds nothing but numbers and names, and so no markup. @param {any} value @param {number} [depth] @returns {boolean} */
export function isPlain(value, depth = 0) {
  if (depth > MAX_DEPTH) return false;
  if (value === null || typeof value === "boolean" || typeof value === "number") return true;
  if (typeof value === "string") return NAME.test(value);
  return Array.isArray(value) ? value.every(one => isPlain(one, depth + 1))
    : Object.entries(value).every(([name, one]) => NAME.test(name) && name !== "__proto__" && isPlain(one, depth + 1));
}

/** The class on one page. */
class Classroom {
  /** @param {any} lesson the page's hooks */
  constructor(lesson) {
    this.lesson = lesson;
    /** @type {Orders} */
    this.orders = NOTHING;
    this.isLecturer = false;
    this.isSuspended = false; // whether this page's own lesson is suspended
    this.began = performance.now(); // when the question on display was shown
    this.hasCopy = false; // whether it shows another page's screen
    this.problem = "";
    this.lastAt = this.lastScreen = "";
    this.link = new Link(message => this.hear(message), () => this.draw());
    this.box = lesson.box.appendChild(make("section", {class: "class-box", "aria-label": "The class"}));
    this.dock = document.body.appendChild(make("section", {class: "class-dock", "aria-label": "Answers of the class", hidden: true}));
    new ResizeObserver(() => document.body.style.setProperty("--dock", `${this.dock.offsetHeight}px`)).observe(this.dock);
    this.inside = make("section", {"aria-label": "Answers of the class"}); // of a card on a phone, instead of the dock
    this.isNarrow = matchMedia("(max-width:900px),(max-width:1000px) and (orientation:portrait)");
    this.isNarrow.addEventListener("change", () => this.draw());
    this.chip = make("button", {type: "button", class: "class-chip", onclick: () => this.dialog.showModal()});
    lesson.head.append(this.chip);
    this.dialog = document.body.appendChild(this.#makeDialog());
    this.challenge = new ClassChallenge(lesson.data, () => this.#sendWhere());
    this.lecturer = new Lecturer(this);
    this.#watch();
    this.link.open();
    this.draw();
  }

  // What this page sends

  #watch() {
    const {lesson} = this;
    lesson.onAnswer = (/** @type {string} */ step, /** @type {any} */ answer) => {
      if (answer.shown) return;
      const found = given(answer, lesson.stage());
      if (found) this.#later({lesson: lesson.state().lesson, step, answer: found, sure: null, phase: "own"});
    };
    lesson.onQuestion = (/** @type {"before" | "after"} */ phase, /** @type {string} */ step, /** @type {any} */ was) =>
      this.#later({lesson: QUESTIONS, step, answer: {choice: was.answer}, sure: was.sure, phase});
    lesson.onStep = () => {
      this.began = performance.now();
      this.#stay();
      this.draw();
    };
    lesson.onTruth = (/** @type {boolean} */ isHidden) => { // which the lecturer alone shows again
      if (this.orders.hidden && !isHidden) lesson.hideTruth(true);
    };
    lesson.onChange = () => this.#sendWhere();
    addEventListener("pagehide", () => this.#sendLast());
    setInterval(() => this.#lead(), LEAD_MS);
  }

  /** @type {Map<string, any>} answers that may still change, as a mark that is dragged */
  #last = new Map();
  #timer = 0;
  /** @param {any} answer */
  #later(answer) {
    if (this.isLecturer || this.orders.lead) return;
    const {asked} = this.orders, isAsked = asked && asked.lesson === answer.lesson && asked.step === answer.step
      && (answer.lesson !== QUESTIONS || asked.phase === answer.phase);
    if (asked && (!isAsked || asked.revealed)) return;
    const seconds = Math.round((performance.now() - this.began) / 100) / 10, round = isAsked ? asked.round : 0;
    this.#last.set(`${answer.lesson}/${answer.step}/${answer.phase}`, {...answer, seconds, round});
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#sendLast(), ANSWER_MS);
  }

  #sendLast() {
    for (const answer of this.#last.values()) {
      if (answer.round) tab.set("voted", String(answer.round));
      this.link.answer(answer);
    }
    this.#last.clear();
    this.draw();
  }

  #atTimer = 0;
  #sendWhere() {
    if (this.isLecturer || this.#atTimer) return;
    this.#atTimer = setTimeout(() => {
      this.#atTimer = 0;
      const at = JSON.stringify(this.challenge.where() ?? this.#where());
      if (at !== this.lastAt && !this.isLecturer) this.link.send(JSON.parse(this.lastAt = at));
    }, AT_MS);
  }

  #where() {
    const {lesson, step, steps, motions, E} = this.lesson.summary(), stage = this.lesson.stage();
    const number = 1 + (this.#lessonOf(lesson)?.steps.findIndex((/** @type {any} */ one) => one.id === step) ?? -1);
    const path = (stage?.motions ?? []).slice(-MAX_POSTURES).flatMap((/** @type {any} */ one) => one.theta.map(round3));
    const {theta, thetaDemo} = stage?.moment ?? {}, isPlane = theta?.length === 2;
    const off = theta ? Math.max(...theta.map((/** @type {number} */ v, /** @type {number} */ k) => Math.abs(v - thetaDemo[k]))) : null;
    return {kind: "at", lesson, step, number, count: steps, motions, answered: Boolean(this.lesson.answer()),
      E: Number.isFinite(E) ? Number(E.toPrecision(4)) : null, off: off === null ? null : Math.round(10 * off / DEGREE) / 10,
      path: isPlane ? path : [], demonstrator: isPlane ? [...thetaDemo].map(round3) : null};
  }

  /** @param {string} name */
  #lessonOf(name) { return this.lesson.lessons().find((/** @type {any} */ one) => one.name === name); }

  /** The lecturer's screen, to all, when it has changed. */
  #lead() {
    if (!this.isLecturer || !this.lecturer.isLeader || !this.orders.lead) return;
    const screen = JSON.stringify(this.screen());
    if (screen === this.lastScreen) return;
    this.lastScreen = screen;
    this.link.send({kind: "state", state: JSON.parse(screen)});
  }

  /** The right answer of the step on display, as the server takes it where the lesson's file does not say it. */
  truth() {
    const stage = this.lesson.stage(), {truth, right, near, kind} = stage?.step.ask ?? {};
    if (!stage || kind === "bet" || !(truth ?? right)) return {};
    const {value} = measure(stage, truth ?? right), isNested = value?.length && typeof value[0] !== "number";
    const corners = (isNested ? Array.from(value) : [value]).map(one => typeof one === "number" ? [one] : Array.from(one));
    const isKnown = corners.length <= MAX_CORNERS && corners.flat().every(Number.isFinite);
    return !isKnown ? {} : {truth: corners, ...near && kind === "place" ? {near: near * (stage.unit === "rad" ? DEGREE : 1)} : {}};
  }

  /** What this page shows, for another page to show. */
  screen() { return this.lesson.state(); }

  // What this page hears

  /** @param {Message} message */
  hear(message) {
    const {kind} = message;
    if (kind === "welcome") this.#welcome(message.lecturer);
    else if (kind === "orders") this.#follow(/** @type {Orders} */ (/** @type {unknown} */ (message)));
    else if (kind === "screen") {
      if (this.orders.lead && !this.isLecturer) this.#show(message.state);
    } else if (kind === "send") this.showCopy(message.state);
    else if (kind === "request") this.link.send({kind: "copy", number: message.number, state: this.screen()});
    else if (kind === "refused") this.problem = `An answer does not count. ${message.why}`;
    else if (kind === "lecturer") {
      tab.set("session", message.session);
      this.#welcome(true);
      this.dialog.close();
      this.#beginAsLecturer();
    } else if (kind === "student") {
      tab.set("session", null);
      location.reload();
    } else if (kind === "wrong") /** @type {HTMLElement} */ (this.dialog.querySelector(".class-wrong")).textContent = message.why;
    this.lecturer.hear(message);
    this.draw();
  }

  /** @param {any} state of another page */
  #show(state) {
    if (!isPlain(state)) return;
    try { this.lesson.lead(state); } catch (error) { console.error(error); } // of another version of the lessons
  }

  /** Another page's screen, to go on from. This page's own lesson is suspended until "Back". @param {any} state */
  showCopy(state) {
    this.#suspend();
    this.hasCopy = true;
    this.#show(state);
    this.lesson.lead(null);
  }

  back() {
    this.hasCopy = false;
    this.#takeBack();
    this.draw();
  }

  /** @param {boolean} isLecturer */
  #welcome(isLecturer) {
    this.isLecturer = isLecturer;
    this.lastAt = this.lastScreen = "";
    document.body.classList.toggle("lecturer", isLecturer);
    if (isLecturer) this.lesson.freeze(false);
    else this.#sendWhere();
  }

  /** What this page did as a student's ends: the orders are followed again, as a lecturer's page does. */
  #beginAsLecturer() {
    const {orders} = this;
    this.lesson.lead(null);
    this.#takeBack();
    this.orders = NOTHING;
    this.#follow(orders);
  }

  /** @param {Orders} orders */
  #follow(orders) {
    const before = this.orders, {lesson, isLecturer} = this;
    this.orders = orders;
    lesson.hideTruth(orders.hidden);
    this.challenge.follow(orders.gather, !isLecturer && !orders.asked && !orders.lead);
    if (!isLecturer) lesson.freeze(orders.frozen && !orders.asked); // a question is for all to answer
    this.#takeQuestion(before.asked, orders.asked);
    if (!isLecturer && orders.lead && !orders.asked) this.#suspend();
    else if (before.lead && !orders.lead && !isLecturer) {
      lesson.lead(null);
      if (!orders.asked) this.#takeBack();
    }
    if (isLecturer || orders.asked || orders.lead) return;
    const {gather, reset} = orders;
    if (gather && Number(tab.get("gathered") ?? 0) !== gather.number) {
      tab.set("gathered", String(gather.number));
      if (!this.challenge.place) this.goTo(gather.lesson, gather.step, "before", gather.seed);
    }
    const done = tab.get("reset");
    if (done !== null && Number(done) !== reset) lesson.askAgain();
    tab.set("reset", String(reset));
  }

  /** @param {Asked | null} before @param {Asked | null} asked */
  #takeQuestion(before, asked) {
    const {lesson, isLecturer} = this;
    if (!asked) {
      if (!before) return;
      lesson.hold(false);
      lesson.showOthers(null);
      this.lecturer.showsAnswers = false;
      if (!isLecturer) this.#takeBack();
      return;
    }
    if (asked.round !== before?.round) {
      this.problem = "";
      this.lecturer.showsAnswers = false;
      lesson.showOthers(null);
      if (!isLecturer) {
        lesson.lead(null);
        this.#suspend();
      }
      lesson.hold(true);
      this.goTo(asked.lesson, asked.step, asked.phase, asked.seed);
      lesson.askAgain();
      this.began = performance.now();
    }
    if (asked.revealed && (asked.round !== before?.round || !before.revealed)) {
      lesson.hold(false);
      lesson.reveal();
      if (isLecturer) delete lesson.stage()?.answer.shown; // the lecturer needs no advice to guess
    }
    if (asked.revealed) this.showResults(asked.results);
  }

  /** In the picture and beside the answers. @param {Results | null} results */
  showResults(results) {
    const {now} = results ?? {}, {stage} = this.lesson, kind = stage()?.step.ask.kind;
    const marks = kind === "pose" ? now?.values.map(([u, v]) => [u * DEGREE, v * DEGREE]) : now?.values;
    const inCard = this.isNarrow.matches && !results?.before && !results?.first; // else the bars stand in the dock
    this.lesson.showOthers(!now ? null : kind === "choice" ? inCard ? {counts: now.counts} : null
      : kind === "place" || kind === "pose" ? {marks} : null);
  }

  /** Students stay at the question, and where the lecturer is. */
  #stay() {
    const {asked} = this.orders;
    if (!asked || this.isLecturer || this.#isAt(asked)) return;
    this.goTo(asked.lesson, asked.step, asked.phase, asked.seed);
  }

  /** @param {{lesson: string, step: string, phase: string}} where */
  #isAt({lesson, step, phase}) {
    const now = this.lesson.state();
    return lesson === QUESTIONS ? now.step === this.#screenOf(now.lesson, step, phase) : now.lesson === lesson && now.step === step;
  }

  /** Whether a step has a random start. @param {string} name @param {string} id @returns {boolean} */
  #hasRandomStart(name, id) {
    const step = this.#lessonOf(name)?.steps.find((/** @type {any} */ one) => one.id === id);
    return Boolean(step && (step.randomise || step.ask.kind === "predict" || step.carry && this.#hasRandomStart(name, step.carry)));
  }

  /** How a screen of the eight questions is named. @param {string} lesson @param {string} item @param {string} phase */
  #screenOf(lesson, item, phase) {
    const k = this.#lessonOf(lesson)?.questions?.findIndex((/** @type {any} */ one) => one.id === item) ?? -1;
    return k < 0 ? null : `${phase === "after" ? "after" : "before"}-${k + 1}`;
  }

  /** @param {string} name @param {string} step @param {string} phase @param {number} seed of a random start: the same for all */
  goTo(name, step, phase, seed) {
    const all = this.lesson.lessons(), now = this.lesson.state().lesson;
    if (name !== QUESTIONS) return this.lesson.goTo(name, step, this.#hasRandomStart(name, step) ? seed : undefined);
    const found = [this.#lessonOf(now), ...all].find(one => one?.questions?.length);
    return found && this.lesson.goTo(found.name, this.#screenOf(found.name, step, phase));
  }

  #suspend() {
    if (this.isSuspended) return;
    this.isSuspended = true;
    this.lesson.suspend();
  }

  #takeBack() {
    this.hasCopy = false;
    if (!this.isSuspended) return;
    this.isSuspended = false;
    this.lesson.back();
  }

  // What this page shows of the class

  draw() {
    const {asked} = this.orders, {link} = this, waiting = link.waiting().length;
    const isOffline = !link.isOpen && performance.now() > 3000;
    this.chip.className = `class-chip${link.isOpen ? " on" : ""}`;
    this.chip.textContent = this.isLecturer ? "Lecturer" : browser.get("name") || "Class";
    this.chip.title = link.isOpen ? "Connected to the class" : "Not connected to the class";
    const lines = [];
    if (isOffline) lines.push(make("p", {class: "class-note warns"}, waiting
      ? `No connection to the class. ${waiting} ${waiting === 1 ? "answer waits" : "answers wait"} here and will be sent.`
      : "No connection to the class. You can go on; this page connects again by itself."));
    if (isOffline && link.cause) lines.push(make("p", {class: "class-note"}, link.cause));
    if (this.problem) lines.push(make("p", {class: "class-note warns"}, this.problem));
    if (this.hasCopy && !asked) lines.push(make("p", {class: "class-note"}, this.isLecturer ? "This is a copy of a student’s screen. " : "The lecturer has sent this screen. ",
      make("button", {type: "button", class: "link", onclick: () => this.back()}, "Back to mine")));
    if (!this.isLecturer) lines.push(...this.#studentsLines(asked, waiting));
    const results = asked ? this.#questionLines(asked) : [];
    fill(this.box, lines);
    fill(this.inside, this.isNarrow.matches ? results : []);
    fill(this.dock, this.isNarrow.matches ? [] : results);
    if (!this.inside.hidden && !this.inside.isConnected) $("body").append(this.inside); // a new screen has removed it
    document.body.classList.toggle("class-docked", !this.dock.hidden);
    document.body.classList.toggle("class-asks", Boolean(asked && (!asked.revealed || !this.isLecturer)));
    this.lecturer.draw();
  }

  /** @param {Asked | null} asked @param {number} waiting */
  #studentsLines(asked, waiting) {
    const {orders} = this;
    if (asked && !asked.revealed) {
      const hasVoted = tab.get("voted") === String(asked.round);
      const words = !hasVoted ? "The class is asked: what do you say?"
        : waiting ? "Your answer is on its way." : "Your answer is in. You may change it.";
      return [make("p", {class: "class-note"}, make("b", {}, words), hasVoted ? "" : " Nobody’s name goes with it.")];
    }
    if (asked) return [];
    if (orders.lead) return [make("p", {class: "class-note"}, make("b", {}, "The lecturer leads."), " This page follows.")];
    if (orders.frozen) return [make("p", {class: "class-note"}, make("b", {}, "The lecturer has frozen this page."))];
    if (this.lesson.state().step !== "home" || !this.link.isOpen) return [];
    return [make("p", {class: "class-note"}, make("b", {}, "You are in the class. "), "Wait for the lecturer, or begin a lesson. ",
      make("button", {type: "button", class: "link", onclick: () => { this.dialog.showModal(); this.code?.focus(); }}, "Lecturer: enter the code"))];
  }

  /** The answers, once they may be seen here. @param {Asked} asked */
  #questionLines(asked) {
    const results = asked.revealed ? asked.results : this.isLecturer && this.lecturer.showsAnswers ? this.lecturer.results : null;
    if (!results || !this.#isAt(asked)) return [];
    const question = asked.lesson === QUESTIONS
      ? this.lesson.lessons().flatMap((/** @type {any} */ one) => one.questions ?? []).find((/** @type {any} */ one) => one.id === asked.step) : null;
    return [resultsOf(results, {asked, question, stage: this.lesson.stage(), isNarrow: this.isNarrow.matches})];
  }

  #makeDialog() {
    const name = make("input", {type: "text", maxlength: 24, value: browser.get("name") ?? "", autocomplete: "off"});
    const linked = make("input", {type: "checkbox"}), code = this.code = make("input", {type: "password", autocomplete: "off"});
    linked.checked = browser.get("unlinked") !== "yes";
    const tell = () => {
      browser.set("name", name.value.trim() || null);
      browser.set("unlinked", linked.checked ? null : "yes");
      this.link.send({kind: "self", name: name.value.trim(), linked: linked.checked});
      this.draw();
    };
    name.addEventListener("change", tell);
    linked.addEventListener("change", tell);
    const login = (/** @type {Event} */ event) => {
      event.preventDefault();
      this.link.send({kind: "login", code: code.value});
      code.value = "";
    };
    return make("dialog", {class: "class-dialog", closedby: "any", "aria-label": "The class"},
      make("form", {method: "dialog"}, make("button", {class: "close", "aria-label": "Close"}, "×")),
      make("h2", {}, "The class"),
      make("p", {}, "This page belongs to a class. The lecturer sees at which step it is, and how often each answer was given. ",
        "Your answers are kept under a random number, without a name."),
      make("label", {}, make("span", {}, "Your name, if you like: the lecturer alone sees it"), name),
      make("label", {class: "check"}, linked, make("span", {}, "My answers may be linked to each other, to measure what the class has learned")),
      make("form", {class: "class-login", onsubmit: login}, make("label", {}, make("span", {}, "Lecturer: the code from the terminal"), code),
        make("button", {class: "plain"}, "Enter")),
      make("p", {class: "class-wrong", role: "alert"}));
  }
}

/** Draw it again if it differs. @param {HTMLElement} box @param {HTMLElement[]} parts */
function fill(box, parts) {
  const key = parts.map(part => part.outerHTML).join("");
  box.hidden = !parts.length;
  if (box.dataset.key === key) return;
  box.dataset.key = key;
  box.replaceChildren(...parts);
}

/** @param {number} value */
const round3 = value => Math.round(1000 * value) / 1000;

/** The lessons' page takes a moment to unpack. */
function begin() {
  const {lesson} = /** @type {any} */ (globalThis);
  if (lesson) Object.assign(globalThis, {classroom: new Classroom(lesson)});
  else setTimeout(begin, 30);
}
begin();
