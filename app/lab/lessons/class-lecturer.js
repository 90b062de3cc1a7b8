/** What the lecturer's page has besides: a bar with what the class is to do, and a panel with persons and their steps,
 * everyone's paths, what the class has learned, and how to join.
 * @import {Message} from "./class-link.js" @import {Results} from "./class.js"
 * @typedef {{lesson: string, step: string, number: number, count: number, answered: boolean, motions: number, E:
 * number | null, off: number | null, path: number[], demonstrator: number[] | null}} At
 * @typedef {{place: number, name: string, at: At | null}} Person
 * @typedef {{item: string, persons: number, before: number, after: number}} Item */
import {CHALLENGE, newChallenge} from "./class-challenge.js";
import {tab} from "./class-link.js";
import {button, confirming, inline, make, plain} from "./dom.js";
import {isForPage} from "../view/keys.js";
import {EnergyMap} from "../view/map.js";
import {add, energyText, escaped} from "../view/svg.js";
import {stepsText} from "../view/words.js";

const TABS = ["Students", "Paths", "Standings", "Gain", "Join", "More"];
const SORTS = /** @type {Record<string, (one: Person) => number>} */ ({
  place: one => one.at?.number ?? -1, E: one => -(one.at?.E ?? -1), steps: one => -(one.at?.motions ?? 0),
});
const SAME_RAD = 0.002, TILE = {width: 120, height: 66};

export class Lecturer {
  /** @param {any} room the page's class */
  constructor(room) {
    this.room = room;
    this.isLeader = false;
    this.showsAnswers = false; // whether answers are shown here before they are revealed
    this.people = /** @type {Map<number, Person>} */ (new Map());
    this.results = /** @type {Results | null} */ (null);
    /** @type {any} */
    this.count = {problem: null, asked: []};
    this.gain = /** @type {any} */ (null);
    this.invitation = /** @type {{address: string, qr: string} | null} */ (null);
    this.tab = "";
    this.sort = "place";
    this.note = "";
    this.bar = document.body.appendChild(make("section", {class: "class-bar", "aria-label": "What the class does", hidden: true}));
    this.panel = document.body.appendChild(make("section", {class: "class-panel", "aria-label": "The class", hidden: true}));
    document.addEventListener("keydown", event => this.#key(event), true);
  }

  /** @param {Message} message */
  hear(message) {
    const {kind} = message;
    if (kind === "leader") this.isLeader = message.here;
    else if (kind === "people") {
      if (message.all) this.people.clear();
      for (const one of message.people) this.people.set(one.place, one);
      for (const place of message.gone) this.people.delete(place);
    } else if (kind === "count") {
      this.count = message;
      this.results = message.results;
      if (this.showsAnswers) this.room.showResults(this.results);
    } else if (kind === "csv") save("answers.csv", message.text);
    else if (kind === "gain") this.gain = message.learned;
    else if (kind === "invite") this.invitation = /** @type {any} */ (message);
    else if (kind === "copy") {
      this.tab = "";
      this.room.showCopy(message.state);
    } else if (kind === "done") this.note = message.what;
  }

  /** @param {string} kind @param {object} [fields] */
  order(kind, fields = {}) {
    this.note = "";
    this.room.link.send({kind, ...fields});
  }

  /** What the step on display is called in an order; null for a screen that asks nothing. */
  here() {
    const {lesson, step, seed} = this.room.lesson.state(), one = this.room.lesson.lessons().find((/** @type {any} */ found) => found.name === lesson);
    const [phase, k] = step.split("-"), item = one?.questions?.[Number(k) - 1];
    if ((phase === "before" || phase === "after") && item) return {lesson: "questions", step: item.id, phase};
    return one?.steps.some((/** @type {any} */ found) => found.id === step) ? {lesson, step, phase: "own", seed} : null;
  }

  // The bar

  draw() {
    const {room} = this, isHere = room.isLecturer;
    this.bar.hidden = !isHere;
    this.panel.hidden = !isHere || !this.tab;
    if (!isHere) return;
    const rows = this.#bar(), key = rows.map(one => one.outerHTML).join("");
    if (this.bar.dataset.key !== key) {
      const focused = this.bar.contains(document.activeElement) ? document.activeElement?.textContent : null;
      this.bar.dataset.key = key;
      this.bar.replaceChildren(...rows);
      if (focused) [...this.bar.querySelectorAll("button")].find(one => one.textContent === focused)?.focus({preventScroll: true});
    }
    if (this.tab) this.#drawPanel();
  }

  #bar() {
    const {orders, link} = this.room, {asked} = orders, here = this.here(), count = this.people.size;
    const order = (/** @type {string} */ words, /** @type {() => void} */ act, /** @type {object} */ how = {}) =>
      make("button", {type: "button", onclick: () => { act(); this.draw(); }, ...how}, words);
    /** @type {HTMLElement[]} */
    const rows = [make("button", {type: "button", class: "class-count", "aria-expanded": String(Boolean(this.tab)), title: "Who is here (M)", onclick: () => this.open(this.tab ? "" : "Students")},
      make("b", {}, String(count)), " here")];
    if (!link.isOpen) return [...rows, make("span", {class: "warns"}, "No connection to the class’s server.")];
    if (!this.isLeader) return [...rows, make("span", {class: "warns"}, "Another of your pages leads the class."), order("Take over", () => this.order("do", {what: "take"}), {class: "filled"})];
    if (asked) {
      const total = this.results?.now.total ?? 0;
      rows.push(make("span", {class: "class-asked"}, make("b", {}, `${total} of ${count}`), asked.times > 1 ? ` answered, round ${asked.times}` : " answered"));
      if (!this.#isAtQuestion()) rows.push(order("Go to the question", () => this.#goToQuestion()));
      if (!asked.revealed) rows.push(order(this.showsAnswers ? "Hide answers" : "Show answers", () => this.#showAnswers(), {"aria-pressed": String(this.showsAnswers)}),
        order("Reveal", () => this.#reveal(), {class: "filled"}));
      rows.push(order("Ask again", () => this.#askAgain(), {class: asked.revealed ? "filled" : ""}),
        order("Close the question", () => this.order("do", {what: "close"})));
    } else {
      const again = here && this.count.asked.some((/** @type {any} */ one) => one.lesson === here.lesson && one.step === here.step && one.phase === here.phase);
      rows.push(order(again ? "Ask again" : "Ask the class", () => this.order("ask", this.here() ?? {}), {class: "filled", disabled: !here}),
        order("Gather here", () => this.#gather(), {disabled: !here, title: "All go to this step, and on at their own pace"}),
        order("Challenge", () => this.#challenge(), {title: "All get one pose to copy, in as few steps as possible"}),
        order(orders.lead ? "Release" : "Lead", () => this.order("switch", {what: "lead", on: !orders.lead}), {"aria-pressed": String(orders.lead), title: "All follow this page"}));
    }
    rows.push(order(orders.frozen ? "Unfreeze" : "Freeze", () => this.order("switch", {what: "frozen", on: !orders.frozen}), {"aria-pressed": String(orders.frozen), title: "Lock the pages of all"}),
      order(orders.hidden ? "Show truth" : "Hide truth", () => this.#hide(), {"aria-pressed": String(orders.hidden), title: "On all screens (T)"}));
    if (this.count.problem) rows.push(make("span", {class: "warns"}, this.count.problem));
    if (this.note) rows.push(make("span", {class: "class-said"}, this.note));
    rows.push(order("Large", () => this.#present(), {class: "class-large", title: "Large letters for a projector (P)", "aria-pressed": String(this.isPresenting)}));
    return rows;
  }

  #askAgain() {
    const {asked} = this.room.orders;
    if (asked) this.order("ask", {lesson: asked.lesson, step: asked.step, phase: asked.phase, seed: asked.seed});
  }

  #reveal() {
    if (!this.#isAtQuestion()) this.#goToQuestion();
    this.order("reveal", this.room.truth());
  }

  #isAtQuestion() {
    const {asked} = this.room.orders, here = this.here();
    return asked !== null && here?.lesson === asked.lesson && here?.step === asked.step;
  }

  #goToQuestion() {
    const {asked} = this.room.orders;
    if (asked) this.room.goTo(asked.lesson, asked.step, asked.phase, asked.seed);
  }

  #challenge() {
    this.order("gather", newChallenge());
    this.open("Standings");
  }

  #gather() {
    const {lesson, step, seed} = this.room.lesson.state();
    this.order("gather", {lesson, step, seed});
  }

  get isPresenting() { return document.documentElement.classList.contains("presenting"); }

  #present() {
    document.documentElement.classList.toggle("presenting");
    dispatchEvent(new Event("resize"));
    this.room.lesson.draw();
    this.panel.dataset.key = "";
  }

  #hide() { this.order("switch", {what: "hidden", on: !this.room.orders.hidden}); }

  #showAnswers() {
    this.showsAnswers = !this.showsAnswers;
    this.room.showResults(this.showsAnswers ? this.results : null);
    this.room.draw();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const {key} = event;
    if (!this.room.isLecturer || !isForPage(event)) return;
    const acts = /** @type {Record<string, () => void>} */ ({t: () => this.#hide(), m: () => this.open(this.tab ? "" : "Students"), p: () => this.#present()});
    const act = key === "Escape" && this.tab ? () => this.open("") : acts[key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
    this.draw();
  }

  // The panel

  /** @param {string} name */
  open(name) {
    this.tab = name;
    this.panel.dataset.key = "";
    if (name === "Gain") this.order("do", {what: "gain"});
    if (name === "Join") this.order("invite", {address: /^(localhost|127\.|\[::1\])/.test(location.hostname) ? "" : location.href.replace(/[?#].*/, "")});
    this.draw();
  }

  #drawPanel() {
    const inside = {Students: () => this.#students(), Paths: () => this.#paths(), Standings: () => this.room.challenge.standings([...this.people.values()]), Gain: () => this.#gainOf(), Join: () => this.#join(), More: () => this.#more()}[this.tab];
    const tabs = make("nav", {class: "class-tabs", "aria-label": "The class"}, ...TABS.map(name => make("button", {type: "button", "aria-current": name === this.tab ? "page" : null, onclick: () => this.open(name)}, name)),
      make("button", {type: "button", class: "close", "aria-label": "Close", onclick: () => this.open("")}, "×"));
    const made = inside?.() ?? make("div"), key = this.tab + made.dataset.key + made.outerHTML;
    if (this.panel.dataset.key === key || this.tab === "More" && this.panel.contains(document.activeElement) && this.panel.dataset.key) return;
    const focused = document.activeElement instanceof HTMLElement && this.panel.contains(document.activeElement) ? document.activeElement.dataset.person ?? document.activeElement.textContent : null;
    const scrolled = this.panel.lastElementChild?.scrollTop ?? 0;
    this.panel.dataset.key = key;
    this.panel.replaceChildren(tabs, made);
    made.scrollTop = scrolled;
    this.#drawBowl();
    if (focused) [...this.panel.querySelectorAll("button")].find(one => one.dataset.person === focused || one.textContent === focused)?.focus({preventScroll: true});
  }

  #students() {
    const all = [...this.people.values()], lessons = this.room.lesson.lessons(), isHidden = this.room.orders.hidden;
    const counts = lessons.map((/** @type {any} */ lesson) => {
      const here = all.filter(one => one.at?.lesson === lesson.name);
      if (!here.length) return null;
      const rows = lesson.steps.map((/** @type {any} */ step, /** @type {number} */ k) => {
        const found = here.filter(one => one.at?.step === step.id), done = found.filter(one => one.at?.answered).length;
        return make("li", {title: `${step.title}: ${found.length} here, ${done} have answered`, class: found.length ? "" : "empty"},
          make("i", {style: `--share:${found.length / here.length}`}), make("b", {}, found.length ? String(found.length) : ""), make("span", {}, String(k + 1)));
      });
      const elsewhere = here.filter(one => !lesson.steps.some((/** @type {any} */ step) => step.id === one.at?.step)).length;
      return make("div", {class: "class-steps"}, make("h3", {}, lesson.short), make("ol", {"aria-label": `Students at each step of ${lesson.short}`}, ...rows),
        elsewhere ? make("small", {}, `${elsewhere} at its beginning, its end, or a question`) : null);
    });
    const sorts = make("p", {class: "class-sort"}, "Sort by ", ...Object.keys(SORTS).map(name => make("button", {type: "button", "aria-pressed": String(name === this.sort), onclick: () => { this.sort = name; this.draw(); }}, name)));
    const tiles = all.sort((a, b) => SORTS[this.sort](a) - SORTS[this.sort](b) || a.place - b.place).map(one => this.#tile(one, lessons, isHidden));
    return make("div", {class: "class-inside"}, ...counts, all.length ? sorts : make("p", {class: "text"}, "Nobody is here yet. Students open the address under “Join”."),
      make("div", {class: "class-tiles"}, ...tiles));
  }

  /** @param {Person} one @param {any[]} lessons @param {boolean} isHidden */
  #tile({place: person, name, at}, lessons, isHidden) {
    const lesson = lessons.find(found => found.name === at?.lesson), isSecret = isHidden || at?.lesson === CHALLENGE, step = lesson?.steps.find((/** @type {any} */ found) => found.id === at?.step);
    const where = step ? `${at?.number} ${plain(step.title)}` : lesson?.short ?? "";
    const scene = this.room.lesson.stage()?.scene, {width, height} = TILE;
    const place = (/** @type {number[]} */ [a, b]) => scene ? [4 + (b - scene.lower[1]) / (scene.upper[1] - scene.lower[1]) * (width - 8), 4 + (scene.upper[0] - a) / (scene.upper[0] - scene.lower[0]) * (height - 8)].map(v => v.toFixed(1)) : ["0", "0"];
    const path = pairs(at?.path ?? []).map(place), last = path[path.length - 1], goal = !isSecret && at?.demonstrator ? place(at.demonstrator) : null;
    const drawing = scene && last ? `<svg viewBox="0 0 ${width} ${height}" aria-hidden="true"><path class="way" d="M${path.map(p => p.join(" ")).join("L")}"/>${goal ? `<path class="goal" d="M${goal[0]} ${goal[1]}m-4 0l4-4 4 4-4 4z"/>` : ""}<circle cx="${last[0]}" cy="${last[1]}" r="3.6"/></svg>` : "";
    const facts = [at?.E != null ? `E ${energyText(at.E)} px²` : "", at?.motions ? stepsText(at.motions) : "", !isSecret && at?.off != null && at.motions ? `${at.off}° off` : ""].filter(Boolean);
    return make("button", {type: "button", class: `class-tile${at?.answered ? " answered" : ""}`, "data-person": String(person), title: "Open a copy of this screen", onclick: () => this.order("request", {place: person}),
      html: `<b>${escaped(name || "Student")}</b><span>${escaped(where)}${at?.answered ? " ✓" : ""}</span>${drawing}<small>${escaped(facts.join(" · "))}</small>`});
  }

  /** Everyone's paths on one bowl: of those at the step on display whose demonstrator stands as here. */
  #paths() {
    const stage = this.room.lesson.stage(), {lesson, step} = this.room.lesson.state();
    const at = [...this.people.values()].filter(one => one.at?.lesson === lesson && one.at?.step === step && (one.at?.path.length ?? 0) >= 2);
    if (!stage || stage.moment.theta.length !== 2) return make("div", {class: "class-inside"}, make("p", {class: "text"}, "Go to a step with two joints: its bowl is drawn here, with the path of everyone who is at this step."));
    const here = at.filter(one => one.at?.demonstrator?.every((v, k) => Math.abs(v - stage.moment.thetaDemo[k]) < SAME_RAD));
    const motions = here.map(one => one.at?.motions ?? 0).sort((a, b) => a - b), median = motions[Math.floor(motions.length / 2)] ?? 0;
    const words = here.length ? `${here.length} of ${at.length} at this step have the same target as this page. Steps: ${motions[0]} to ${motions[motions.length - 1]}, median ${median}.`
      : at.length ? `${at.length} are at this step, each with another target than this page.` : "Nobody is at this step.";
    this.shownPaths = here.map(one => pairs(one.at?.path ?? []));
    const made = make("div", {class: "class-inside class-bowl"}, make("p", {class: "text"}, words),
      make("div", {class: "lesson-map"}, make("canvas"), make("div")), make("p", {class: "hint"}, "Dots: where each student is now."));
    made.dataset.key = JSON.stringify([this.shownPaths, lesson, step, this.room.orders.hidden, innerWidth, document.documentElement.dataset.scheme]);
    return made;
  }

  /** @type {number[][][]} */
  shownPaths = [];
  #drawBowl() {
    const box = /** @type {HTMLElement | null} */ (this.panel.querySelector(".lesson-map")), stage = this.room.lesson.stage();
    if (!box || !stage) return;
    box.lastElementChild?.remove();
    const over = add(box, "svg", {class: "vi", role: "img", "aria-label": `Paths of ${this.shownPaths.length} students on the map of E`});
    const map = new EnergyMap(box);
    map.ground(stage.landscape(), {lower: stage.scene.lower, upper: stage.scene.upper, joints: stage.scene.names});
    const lines = this.shownPaths.map(path => path.map(theta => map.place(theta).map(v => v.toFixed(1)))).map(path => {
      const [x, y] = path[path.length - 1];
      return `<path class="class-way" d="M${path.map(p => p.join(" ")).join("L")}"/><circle class="class-dot" cx="${x}" cy="${y}" r="5"/>`;
    }).join("");
    const goal = this.room.orders.hidden ? null : map.place(stage.moment.thetaDemo);
    add(over, "g").innerHTML = lines + (goal ? `<path class="vi-seen" d="M${goal[0]} ${goal[1]}m-6.5 0l6.5-6.5 6.5 6.5-6.5 6.5z"/>` : "");
  }

  #gainOf() {
    const {gain} = this, items = this.room.lesson.lessons().flatMap((/** @type {any} */ one) => one.questions ?? []);
    const refresh = button("Count again", () => this.order("do", {what: "gain"}));
    if (!gain) return make("div", {class: "class-inside"}, make("p", {class: "text"}, "Counting …"));
    if (!gain.enough) return make("div", {class: "class-inside"}, make("p", {class: "text"}, `${gain.persons} ${gain.persons === 1 ? "person has" : "persons have"} answered the eight questions before and after. Below five nothing is shown: single persons could be recognised.`), refresh);
    const two = (/** @type {number} */ value) => value.toFixed(2).replace("-", "−"), percent = (/** @type {number} */ value) => `${Math.round(100 * value)} %`;
    const rows = gain.items.map((/** @type {Item} */ {item, persons, before, after}) => {
      const question = items.find((/** @type {any} */ one) => one.id === item), right = question?.answers.find((/** @type {any} */ one) => one.right);
      const bar = (/** @type {number} */ count, /** @type {string} */ kind, /** @type {string} */ words) => make("span", {class: "gain-row"}, make("i", {class: kind, style: `--share:${count / persons}`}), make("b", {}, `${count} of ${persons} ${words}`));
      return make("li", {}, make("span", {class: "words"}, make("span", {html: inline(question?.text ?? item)}), make("small", {html: inline(right?.text ?? "")})),
        make("span", {class: "pair"}, bar(before, "round-1", "before"), bar(after, "round-0", "after")));
    });
    return make("div", {class: "class-inside"}, make("p", {class: "class-gain"}, make("strong", {}, gain.gain === null ? "All were right before" : `Gain ${two(gain.gain)}`),
      gain.gain === null ? "" : gain.low === null ? "" : ` 95 % interval ${two(gain.low)} to ${two(gain.high)}`, ` · n = ${gain.persons} persons who answered both times · right: ${percent(gain.before)} before, ${percent(gain.after)} after`),
      make("ol", {class: "class-gains"}, ...rows), make("p", {class: "hint"}, "Gain: the share of the answers wrong before that are right after. The interval is from 4000 resamples of the persons."), refresh);
  }

  #join() {
    const found = this.invitation;
    if (!found) return make("div", {class: "class-inside"}, make("p", {class: "text"}, "…"));
    if (!found.address) return make("div", {class: "class-inside"}, make("p", {class: "text"}, "Only this machine reaches the server. Begin it with --host 0.0.0.0, and your students can come."));
    const [size, path] = found.qr.split(/ (.*)/), shown = found.address.replace(/\/$/, "");
    return make("div", {class: "class-inside class-join"}, make("p", {class: "class-address", style: `--chars:${shown.length}`}, shown),
      make("div", {class: "class-qr", html: `<svg viewBox="-2 -2 ${Number(size) + 4} ${Number(size) + 4}" role="img" aria-label="QR code of the address"><rect x="-2" y="-2" width="100%" height="100%" fill="#fff"/><path d="${escaped(path)}" fill="#000"/></svg>`}),
      make("p", {}, make("b", {}, String(this.people.size)), " here"));
  }

  #more() {
    const code = make("input", {type: "password", minlength: 8, maxlength: 100, autocomplete: "new-password", "aria-label": "Another code"});
    const change = (/** @type {Event} */ event) => {
      event.preventDefault();
      if (code.value.trim().length >= 8) this.order("code", {code: code.value});
      code.value = "";
    };
    return make("div", {class: "class-inside class-more"},
      make("h3", {}, "Answers"), make("p", {class: "hint"}, "One line for each answer: person, form, item, phase, answer, right, sure, seconds. Persons are random numbers."),
      make("p", {}, button("Answers as CSV", () => this.order("do", {what: "export"})), confirming("Delete all answers", () => this.order("do", {what: "new"}))),
      make("h3", {}, "All pages"), make("p", {}, button("Send my screen to all, once", () => this.order("state", {state: this.room.screen(), once: true})), confirming("All begin this step again", () => this.order("do", {what: "reset"}))),
      make("h3", {}, "The lecturer’s code"), make("p", {class: "hint"}, "At least eight letters. All other browsers of lecturers are then logged out."),
      make("form", {class: "class-login", onsubmit: change}, code, make("button", {class: "plain"}, "Change the code")),
      make("h3", {}, "This browser"), make("p", {}, button("Leave: no lecturer here any more", () => {
        tab.set("session", null);
        this.order("do", {what: "logout"});
      })));
  }
}

/** @param {number[]} flat */
const pairs = flat => Array.from({length: flat.length >> 1}, (_, k) => [flat[2 * k], flat[2 * k + 1]]);

/** @param {string} name @param {string} text */
function save(name, text) {
  const link = make("a", {href: URL.createObjectURL(new Blob([text], {type: "text/csv"})), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
