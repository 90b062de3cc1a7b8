/** A challenge for a class: all copy one pose, and the lecturer sees who was how fast. It is played on the students'
 * own devices, so nothing but the fun of it depends on the result.
 * @import {Person} from "./class-lecturer.js" @import {Level} from "../challenge/rules.js"
 * @typedef {{number: number, lesson: string, step: string, seed: number}} Place where all are gathered */
import {World} from "../engine/engine.js";
import {squares} from "../challenge/game.js";
import {drawChallenge, degreesOff, LEVELS, POINTS, robotSteps, toLink} from "../challenge/rules.js";
import {Screen} from "../challenge/screen.js";
import {stepsText} from "../view/words.js";
import {make} from "./dom.js";

export const CHALLENGE = "challenge"; // in place of a lesson's name; its steps are the levels
const LEVEL = "points", FIRST = 8, MAX_SEED = 1_000_000;

/** What a lecturer's page orders: a pose that all get. */
export const newChallenge = () => ({lesson: CHALLENGE, step: LEVEL, seed: 1 + Math.floor(Math.random() * (MAX_SEED - 1))});

export class ClassChallenge {
  /** @param {any} page of the lessons @param {() => void} changed */
  constructor(page, changed) {
    this.robot = {scene: page.scenes[page.lessons[0].steps[0].state.scene], hulls: page.hulls};
    this.world = new World(this.robot.scene, POINTS);
    this.changed = changed;
    this.place = /** @type {Place | null} */ (null);
    this.screen = /** @type {Screen | null} */ (null);
    this.dialog = make("dialog", {class: "challenge class-challenge", "aria-label": "A challenge of the class"});
    this.dialog.addEventListener("cancel", event => event.preventDefault());
    document.body.append(this.dialog);
    /** How each student has ended, by their places in the class: the first game counts. @type {Map<number, {steps: number, off: number[]}>} */
    this.ended = new Map();
  }

  /** Follow the lecturer to a challenge, or leave it. @param {Place | null} gather @param {boolean} plays whether this page takes part */
  follow(gather, plays) {
    const place = gather?.lesson === CHALLENGE && gather.step in LEVELS ? gather : null;
    if (place?.number !== this.place?.number) this.ended.clear();
    this.place = place;
    const challenge = place && plays ? this.#challenge(place) : null;
    if (!challenge) return this.dialog.close();
    if (!this.dialog.open) this.dialog.showModal();
    const nowhere = () => {};
    this.screen ??= new Screen(this.dialog, this.robot, {address: () => "", friend: nowhere, robot: nowhere, changed: this.changed});
    this.screen.open(toLink(challenge));
  }

  /** @param {Place} place */
  #challenge({seed, step}) { return drawChallenge(this.world, seed, /** @type {Level} */ (step)); }

  /** Where this page's game is, as a class is told of a step; null for no game. */
  where() {
    const {screen, place} = this, game = this.dialog.open ? screen?.game : null;
    if (!game || !place) return null;
    const {theta, E, off} = game.path[game.made];
    return {kind: "at", lesson: CHALLENGE, step: place.step, number: 1, count: 1, motions: game.made, answered: game.isOver,
      E: Number(E.toPrecision(4)), off: Math.round(10 * off) / 10,
      path: game.path.flatMap(one => one.theta), demonstrator: theta.length === 2 ? game.challenge.demonstrator : null};
  }

  /** Who was there in how many steps, the robot among them. @param {Person[]} people */
  standings(people) {
    const {place} = this, challenge = place && this.#challenge(place);
    if (!place || !challenge) return make("div", {class: "class-inside"}, make("p", {class: "text"}, "“Challenge” gives all students one pose to copy."));
    const {withinDeg} = LEVELS[challenge.level], here = people.filter(({at}) => at?.lesson === CHALLENGE && at.step === place.step
      && at.demonstrator && degreesOff(at.demonstrator, challenge.demonstrator) < 1e-3);
    for (const {place: person, at} of here) if (at?.answered && !this.ended.has(person)) this.ended.set(person, {steps: at.motions,
      off: Array.from({length: at.motions}, (_, k) => degreesOff(at.path.slice(2 * k + 2, 2 * k + 4), challenge.demonstrator))});
    const names = new Map(people.map(({place: person, name}) => [person, name || `Student ${person}`]));
    const there = [...this.ended].filter(([, {off}]) => off.length && off[off.length - 1] <= withinDeg + 1e-3)
      .map(([person, {steps, off}]) => ({name: names.get(person) ?? `Student ${person}`, steps, way: squares(off, withinDeg)}));
    const rows = [...there, {name: "The robot", steps: robotSteps(this.world, challenge) ?? Infinity, way: ""}].sort((a, b) => a.steps - b.steps);
    const shown = rows.filter((one, k) => k < FIRST || !one.way), more = rows.length - shown.length;
    return make("div", {class: "class-inside"},
      make("table", {class: "class-standings"}, make("tbody", {}, ...shown.map(({name, steps, way}) => make("tr", {class: way ? "" : "robot"},
        make("td", {}, String(1 + rows.filter(one => one.steps < steps).length)), make("th", {scope: "row"}, name), make("td", {}, way),
        make("td", {}, stepsText(steps)))))),
      make("p", {class: "text"}, `${more ? `${more} more are there. ` : ""}${here.filter(({at}) => !at?.answered).length} still playing, ${this.ended.size - there.length} did not find it.`),
      make("p", {class: "hint"}, "A game: each device counts its own steps, so give no marks for it. “Gather here” ends it."));
  }
}
