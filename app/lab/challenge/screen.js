/** A challenge on the page: pictures, two sliders and Go, and how it ended. */
import {recovered, World} from "../engine/engine.js";
import {button, confirming, make} from "../lessons/dom.js";
import {Images} from "../view/images.js";
import {copy} from "../view/page.js";
import {say} from "../view/svg.js";
import {stepsText} from "../view/words.js";
import {Game, plainName} from "./game.js";
import {between, Joints, play} from "./joints.js";
import {Played} from "./played.js";
import {levelButtons} from "./maker.js";
import {daily, drawChallenge, fromLink, POINTS, toLink} from "./rules.js";

/** @import {Challenge, Level} from "./rules.js" @import {Scene} from "../engine/world.js"
 * @typedef {{scene: Scene, hulls: Record<string, number[][]>}} Robot
 * @typedef {{address: (challenge: Challenge) => string, robot: (challenge: Challenge, steps: number) => void,
 * friend: (challenge: Challenge) => void, changed?: () => void}} Ways out of the game; address: to share, "" for
 * none; changed: the game has gone on */
const GLIDE_MS = 450, MAX_SEED = 2 ** 31, FULL_PX = 30; // px at which the meter is full
const HELD = [6, 12]; // poses, on a grid over both joints, whose points fit into the windows of L and R
const NOTHING = new Float64Array(4 * POINTS).fill(NaN); // before the end: diamonds and arrows do not show the way
const VIEWS = /** @type {const} */ (["l", "r", "L", "R"]);
const TIP = "A tip: your eyes look at the two arms from opposite sides. So r is nearly the mirror image of L.";

/** The device's date. */
export const today = () => {
  const now = new Date();
  return [now.getFullYear(), now.getMonth() + 1, now.getDate()].map(part => String(part).padStart(2, "0")).join("-");
};

export class Screen {
  /** @param {HTMLElement} box @param {Robot} robot @param {Ways} ways */
  constructor(box, {scene, hulls}, ways) {
    this.box = box;
    this.ways = ways;
    this.world = new World(scene, POINTS);
    this.played = new Played();
    this.game = /** @type {Game | null} */ (null);
    this.stop = /** @type {(() => void) | null} */ (null); // brings the arm to the end of its glide
    this.isMoving = false;
    this.lost = 0; // games, one after the other
    const views = Object.fromEntries(VIEWS.map(view => [view, make("div")]));
    const text = (/** @type {"p" | "b" | "small"} */ tag, /** @type {string} */ kind) => make(tag, {class: kind});
    this.words = {task: text("p", "task"), rule: text("p", "rule"), E: text("b", "E"), change: text("p", "change"),
      count: text("small", "count"), fact: text("p", "fact"), best: text("p", "best")};
    this.said = make("p", {class: "unseen", role: "status"});
    this.meter = make("i");
    this.tries = make("div", {class: "tries", "aria-hidden": true});
    this.verdict = make("h2", {class: "verdict"});
    this.line = make("pre", {class: "line"});
    this.levels = levelButtons(level => this.#choose(level));
    const sliders = make("div", {class: "steered"});
    this.joints = new Joints(sliders, scene.names.map((name, k) => ({name: plainName(name), low: scene.lower[k],
      high: scene.upper[k]})), theta => this.#go(theta), confirming("Give up", () => this.#end()));
    this.copying = button("Copy result", () => void copy(this.copying, this.line.textContent ?? "", "Your result:"), "filled");
    this.pictures = make("section", {class: "four", "aria-label": "Four pictures"},
      make("p", {class: "of"}, make("b", {}, "The orange arm"), make("span", {}, ", your left and right eye")), views.l, views.r,
      make("p", {class: "of"}, make("b", {}, "Your blue arm"), make("span", {}, ", your left and right eye")), views.L, views.R);
    const {task, rule, E, count, change, fact, best} = this.words;
    box.append(
      make("section", {class: "brief"}, this.levels.element, task, rule),
      this.pictures,
      make("section", {class: "playing", "aria-label": "Play"}, E, make("span", {class: "meter", "aria-hidden": true}, this.meter),
        make("div", {class: "made"}, this.tries, count), change, sliders),
      make("section", {class: "ended", "aria-label": "Result"}, this.verdict, fact, best, this.line, this.copying,
        make("div", {class: "next"}, button("Another", () => this.#openAnother(this.#now.challenge.level)),
          button("Challenge a friend", () => ways.friend(this.#now.challenge)),
          button("How did the robot do it?", () => ways.robot(this.#now.challenge, this.#now.robot ?? 0)))),
      this.said);
    this.images = new Images(views, hulls);
    const {lower, upper} = scene;
    this.images.hold(this.world, Array.from({length: HELD[0] * HELD[1]}, (_, i) => [i % HELD[0], Math.floor(i / HELD[0])].map((at, k) =>
      lower[k] + at / (HELD[k] - 1) * (upper[k] - lower[k]))));
    new ResizeObserver(() => {
      this.images.measure();
      if (!box.hidden) this.draw();
    }).observe(this.pictures);
  }

  /** The game that is played. */
  get #now() {
    if (!this.game) throw new Error("no challenge is open");
    return this.game;
  }

  /** Play what an address asks for; what it asked for before goes on. @param {string} hash */
  open(hash) {
    const asked = fromLink(this.world, hash.replace(/challenge=today(?=&|$)/, `challenge=${today()}`)), challenge = asked ?? daily(this.world, today(), "points");
    if (!challenge) throw new Error("this robot has no pose that makes a challenge");
    if (this.game && toLink(challenge) === toLink(this.game.challenge)) return;
    this.stop?.();
    const game = this.game = new Game(this.world, challenge), {by, day} = challenge, {withinDeg, says} = game.level;
    const whose = day === today() ? "The pose of today." : day ? `The pose of ${day}.` : by ? `${by} posed the orange arm.`
      : "A pose of the orange arm.";
    const wrong = asked ? "" : "This link holds no challenge. Here is today’s. ";
    say(this.words.task, `${wrong}${whose} Copy it in fewer steps than the robot: ${game.robot ?? "–"}.`);
    say(this.words.rule, `Set both joints, press Go: one step. Within ${withinDeg}° you are there. ${says}`);
    for (const element of [this.said, this.words.change]) say(element, "");
    say(this.verdict, "Not over yet");
    this.joints.reset();
    this.images.measure();
    this.draw();
  }

  /** A day has one pose for each level. @param {Level} level */
  #choose(level) {
    const {challenge, isOver} = this.#now;
    if (!challenge.day || isOver && challenge.level === level) this.#openAnother(level);
    else location.hash = toLink({...challenge, level});
  }

  /** @param {Level} level */
  #openAnother(level) {
    const other = drawChallenge(this.world, Math.floor(Math.random() * MAX_SEED), level);
    if (other) location.hash = toLink(other);
  }

  /** @param {number[]} theta */
  #go(theta) {
    const game = this.#now, from = game.moment.theta;
    this.isMoving = true;
    this.stop = play(GLIDE_MS, share => {
      game.pass(between(from, theta, share));
      this.draw();
    }, () => {
      this.isMoving = false;
      game.step(theta);
      if (game.isOver) return this.#end();
      const {change, made, level, disagreement} = game;
      say(this.words.change, `${change[0].toUpperCase()}${change.slice(1)}.`);
      say(this.said, `Step ${made} of ${level.tries}. ${disagreement}, ${change}.`);
      this.draw();
    });
  }

  #end() {
    const game = this.#now, {challenge, made, isThere, verdict, fact} = game;
    if (this.isMoving) return;
    game.isOver = true;
    this.lost = isThere ? 0 : this.lost + 1;
    const {isPractice, best} = this.played.add(challenge, isThere ? made : 0);
    say(this.verdict, verdict);
    say(this.words.fact, fact);
    say(this.words.best, isPractice ? "This was practice: the first game of a pose counts." : this.lost > 1 ? TIP
      : best ? `Best on this device: ${stepsText(best)}.` : "");
    say(this.line, made ? game.line(this.ways.address(challenge), isPractice) : "");
    this.line.hidden = this.copying.hidden = !made;
    say(this.said, `${verdict} ${fact}`);
    this.draw();
    this.verdict.tabIndex = -1;
    this.verdict.focus();
  }

  draw() {
    const {game, box, isMoving} = this;
    if (!game) return;
    const {moment, isOver, path, made, level: {tries}, challenge: {level, day}, disagreement} = game, px = path.map(({E}) => Math.sqrt(E));
    box.dataset.level = level;
    box.dataset.over = String(isOver);
    if (level !== "blindfold" || isOver) this.#drawPictures(game);
    this.levels.show(level, !isOver && !day);
    say(this.words.E, isMoving ? "…" : disagreement);
    this.meter.style.width = `${Math.min(100, 100 * Math.sqrt(moment.E) / FULL_PX)}%`;
    this.tries.replaceChildren(...Array.from({length: tries}, (_, k) => k < made
      ? make("i", {class: "made", style: `--high:${px[k + 1] / Math.max(...px)}`}, px[k + 1].toFixed(1)) : make("i")));
    say(this.words.count, made ? `${stepsText(made)} of ${tries}` : `${tries} steps at most`);
    this.joints.show(moment.theta, isMoving, isOver);
    if (!isMoving) this.ways.changed?.();
  }

  /** @param {Game} game */
  #drawPictures({moment, isOver}) {
    this.images.draw(this.world, {moment, recovered: isOver ? recovered(moment) : NOTHING, lines: [], chosen: -1,
      goal: isOver, bones: null, ease: 1});
    for (const {view, svg} of this.images.views) svg.setAttribute("aria-label",
      `Picture ${view}: ${view < "a" ? "your arm" : "the orange arm"}, ${/l/i.test(view) ? "left" : "right"} eye`);
  }
}
