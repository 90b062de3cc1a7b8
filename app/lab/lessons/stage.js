/** A step of a lesson at one moment: its two arms, the answer, and how far its reveal has gone. Figures, measures
 * and the card read it and nothing else. It touches no document.
 * @typedef {import("../engine/world.js").Scene & {page?: {scene: string | null, layouts: string[], preset: string |
 * null}}} Scene page: as viewimit's page names it, and the lab's preset; null where there is none
 * @import {Moment} from "../engine/session.js" @import {Camera} from "../engine/camera.js"
 * @typedef {[number, number]} Mark a place in a figure, in its unit
 * @typedef {{value: any, unit: string, text: string}} Measured value: a number, a place or a posture; text: with its
 * unit
 * @typedef {(stage: Stage) => Measured} Measure
 * @typedef {{scene: string, points: number, transfer: string, servo: string, demonstrator: number[], start:
 * number[], noisePx?: number, missing?: number, seed?: number}} State where a step begins; scene: its key;
 * demonstrator: rad; start: rad
 * @typedef {{value: number, cameras: Camera[]}[]} Variants the eyes at a slider's
 * values
 * @typedef {{state: State, facts?: Record<string, Measured>, records?: Record<string, any>, variants?:
 * Record<string, Variants>}} Sample one of those that the seed picks from, laid over the step's own
 * @typedef {{figure: string, show?: string[], reveal?: string[], hide?: string[]}} FigureUse
 * @typedef {{name: string, label: string, low: number, high: number, start: number, step?: number, unit?: string |
 * null, logarithmic?: boolean}} Slider name: what it moves, see `Stage.slide`; unit: null for no number at all
 * @typedef {{text: string, because: string, right?: boolean, belief?: string | null}} Choice
 * @typedef {{kind: "choice" | "place" | "pose" | "number" | "do" | "predict" | "bet", question: string, close?: string,
 * far?: string}} AskOfAll close, far: replies
 * @typedef {{answers?: Choice[], right?: string | null}} AskChoice right: the measure whose number says which answer is
 * right, from 1
 * @typedef {{figure?: string | null, truth?: string | null, near?: number, line?: string | null, on_line?: string | null,
 * elsewhere?: {truth: string, near: number, because: string, belief?: string}[]}} AskPlace of a pose, too, and truth of
 * a number and of a bet; truth: a measure; near: px, degrees on maps and of poses; line: a measure below which the mark
 * is on the right way though far, with the reply on_line; elsewhere: other places, with a reply
 * @typedef {{unit?: string, low?: number, high?: number, step?: number | null, logarithmic?: boolean, less?: string | null,
 * factor?: number | null, within?: number | null}} AskNumber less: the reply to too little; factor, within: by how much a
 * guess may differ to be close
 * @typedef {{measure?: string | null, below?: number | null, above?: number | null, counted?: boolean,
 * times?: number | null}} AskGoal to do, or to predict; measure: what has to be reached; counted: each release of a
 * slider is one motion; times: rounds of predictions at most, or runs that are bet on
 * @typedef {AskOfAll & AskChoice & AskPlace & AskNumber & AskGoal} Ask
 * @typedef {{id: string, title: string, text: string, say: string, after?: string, ask: Ask, chosen?: number | null,
 * headline?: {measure: string, label: string, note?: string} | null}} StepWords
 * @typedef {{main?: FigureUse[], side?: FigureUse[], sliders?: Slider[], race?: string[], play?: number | null,
 * meets?: boolean, carry?: string | null, randomise?: boolean}} StepPlay play: seconds that the animation of the reveal
 * takes; meets: the reveal brings the learner to the demonstrator's posture; carry: the id of the step whose start and
 * path go on here
 * @typedef {{state: State, facts?: Record<string, Measured>, records?: Record<string, any>,
 * variants?: Record<string, Variants>, samples?: Sample[] | null}} StepData facts: that the library has computed
 * @typedef {StepWords & StepPlay & StepData} Step
 * @typedef {{id: string, text: string, answers: {text: string, because: string, right?: boolean, belief?: string |
 * null}[], step?: string | null}} Question one of the eight; step: "lesson/step" that shows it
 * @typedef {{name: string, title: string, short: string, about: string, minutes: number, questions?: Question[] |
 * null, steps: Step[]}} Lesson
 * @typedef {{scenes: Record<string, Scene>, hulls: Record<string, number[][]>, glossary?: Record<string, string>}}
 * Page what all steps share; hulls: outermost vertices of links; glossary: sentences by term
 * @typedef {{choice?: number, place?: Mark, number?: number, pose?: number[], bet?: number, done?: boolean, shown?:
 * boolean}} Answer the answer to a step; choice: from 0; pose: degrees; bet: 0 … 100 %; done: whether the goal was
 * reached; shown: shown without an answer
 * @typedef {{mark: Mark, from: Mark, to: Mark, knobs: number[], measure: number}} Round of predictions; from, to: of
 * the ringed point; measure: of the ask, after the turn
 * @typedef {{theta: number[], E: number, probe: boolean, shown?: boolean}} Motion shown: by the page, not made by
 * hand
 * @typedef {{postures: number[][], E: number[], probes: boolean[], claim: Claim}} Race
 * @typedef {Object} Claim how a run ended
 * @property {string} status
 * @property {number} seen points at the end
 * @property {number[]} unobservable joints that the learner knows nothing of
 * @property {number | null} expectedOffDeg what the learner expects to be off; null if it does not say
 * @property {number[][]} swapped pairs of points that the learner takes to bear each other's names
 * @typedef {Object} Figure a drawing in its box
 * @property {(stage: Stage, layers: Set<string>) => void} draw the whole of it, at most once a frame, with its text
 *   alternative
 * @property {(stage: Stage, mark: Mark) => [number, number] | null} [place] px in the box of a mark
 * @property {(stage: Stage, at: [number, number]) => Mark | null} [unplace] the mark at px in the box; null outside
 * @property {() => void} [resize]
 * @property {() => void} [remove] before its box goes
 * @typedef {Object} FigureKind
 * @property {string[]} layers that a lesson may name
 * @property {string} [title]
 * @property {"px" | "rad"} [unit] of its marks, px by default; maps have rad
 * @property {number} [aspect] width over height that suits it
 * @property {Record<string, string>} [legend] of layers, as HTML; equal ones stand once
 * @property {(box: HTMLElement, stage: Stage) => Figure} create */
import {stageMap} from "./maps.js";
import {clamp, DEGREE, draws, geometry, recovered, SERVOS, Session, World} from "../engine/engine.js";

const RACE_GOAL = 3; // px², of E in a race whose step names no other
/** How servos are drawn and named: role, name. @type {Record<string, [string, string]>} */
const RACERS = {likelihood: ["learner", "likelihood"], broyden: ["opponent", "Broyden"],
  "gradient-retuned": ["plain", "gradient law"], gradient: ["plain", "the paper’s law"]};
const MAX_MOTIONS = 200, MAX_RACE = 400;
const KNOB_RAD = 20 * DEGREE, KNOB_GAINS = [.6, 1.2]; // rad of a joint at a knob's full turn, times these
const SETTINGS = /** @type {const} */ ({noise_px: "noisePx", missing: "missing", seed: "seed", transfer: "transfer"});

export class Stage {
  /** @param {Page} page @param {Step} step
   * @param {{seed?: number, previous?: Stage | null}} [from] seed: of the random state, from 1; previous: the step
   * that goes on here */
  constructor(page, step, {seed = 1, previous = null} = {}) {
    this.page = page;
    /** @type {Step} */
    this.step = step;
    /** @type {Stage | null} */
    this.previous = previous;
    /** @type {number} */
    this.seed = previous?.step.randomise ? previous.seed : seed;
    const samples = step.samples ?? [];
    /** @type {Sample | null} what the seed has picked */
    this.sample = samples.length ? samples[(this.seed - 1) % samples.length] : null;
    const going = previous && {demonstrator: previous.state.demonstrator, start: previous.state.start};
    /** @type {State} */
    this.state = {...step.state, ...going ?? {}, ...this.sample?.state};
    /** @type {Record<string, Measured>} */
    this.facts = {...step.facts, ...this.sample?.facts};
    /** @type {Record<string, any>} */
    this.records = {...step.records, ...this.sample?.records};
    /** @type {Record<string, Variants>} */
    this.variants = {...step.variants, ...this.sample?.variants};
    this.knobs = randomKnobs(this.seed); // rad of both joints for each knob's full turn
    this.chosen = step.chosen ?? 0;
    this.reveal = 0; // 0 before the answer, 1 after it; between, while the reveal is played
    this.answer = /** @type {Answer} */ ({});
    this.mark = /** @type {Mark | null} */ (null); // in the asking figure's unit
    /** @type {Record<string, Measured> | null} measures that judge the answer, as they were when the truth was shown */
    this.graded = null;
    /** @type {"px" | "rad"} the asking figure's */
    this.unit = "px";
    this.truthHidden = false; // whether what the learner cannot know is left out
    this.others = /** @type {Mark[]} */ ([]); // of a class, in the asking figure's unit
    this.rounds = /** @type {Round[]} */ ([]); // predictions and what came of them
    this.run = 0; // which run of a bet is shown, from 0
    this.bets = /** @type {(number | null)[]} */ ([]); // bets on the runs, %
    /** Called when something has changed that is drawn. */
    this.changed = () => {};
    this.raced = /** @type {Record<string, Race>} */ ({});
    this.scene = page.scenes[this.state.scene];
    this.world = new World(this.scene, this.state.points);
    const {transfer, servo, demonstrator, start, noisePx, missing, seed: noise} = this.state;
    this.session = new Session(this.world, {transfer, servo: servo in SERVOS ? servo : "broyden", demonstrator, start,
      noisePx, missing, seed: noise ?? 7});
    /** @type {Moment} the current images */
    this.moment = this.session.now;
    /** @type {Motion[]} made by hand, the start first, and perhaps one that was shown */
    this.motions = [{theta: this.moment.theta, E: this.moment.E, probe: false}];
    this.carried = previous?.motions; // the earlier step's motions, with which this one goes on
    if (previous) this.#goOn(previous);
    /** @type {Map<string, number>} where the sliders stand, in their own units */
    this.sliders = new Map((step.sliders ?? []).map(slider => [slider.name, this.#standing(slider)]));
    for (const {name, start: value} of step.sliders ?? []) if (this.variants[name]
      || name in SETTINGS) this.slide(name, value);
  }

  /** How many runs are bet on. */
  get runs() { return Math.min(this.step.ask.times ?? 1, this.records.runs?.length ?? 1); }

  get hulls() { return this.page.hulls; }

  /** The races of the step, by servo. @returns {Record<string, Race>} */
  get races() {
    const {race = []} = this.step, own = Object.fromEntries(race.map(servo =>
      [servo, this.race(servo)]).filter(([, found]) => found));
    return {...this.records.races, ...own};
  }

  /** E, or another measure, that has to be reached here or in the step that goes on here; null for none. */
  get goal() {
    const ask = this.previous && this.step.ask.kind !== "do" ? this.previous.step.ask : this.step.ask;
    const reached = ask.kind === "do" || ask.kind === "predict" ? ask.below ?? ask.above ?? null : null;
    return reached ?? (this.step.race?.length ? RACE_GOAL : null);
  }

  /** Whether the answer has been given, and the truth may be drawn. */
  get isRevealed() { return this.reveal > 0; }

  /** See the arm in a posture: nothing is counted. @param {number[]} theta */
  observe(theta) {
    const {lower, upper} = this.scene;
    this.moment = this.session.observe(theta.map((v, k) => clamp(v, lower[k], upper[k])));
  }

  /** Go on where the earlier step has ended, or where a servo brings the arm if its goal was not reached. @param {Stage} previous */
  #goOn(previous) {
    const {motions, goal, step: {ask}} = previous, last = motions[motions.length - 1];
    if (motions.length > 1) {
      this.motions = motions;
      this.observe(last.theta);
    }
    const race = ask.kind === "do" && ask.measure === "E" && goal !== null && last.E >= goal ? previous.race("broyden") : null;
    if (race) this.showAt(race.postures[race.postures.length - 1]);
  }

  /** How many motions were made by hand. */
  get steps() { return this.motions.filter(({shown}) => !shown).length - 1; }

  /** Whether the arm has come here without a hand. */
  get isShown() { return Boolean(this.motions[this.motions.length - 1].shown); }

  /** Show the arm in a posture as the end of its way, which does not count. @param {number[]} theta */
  showAt(theta) {
    this.observe(theta);
    this.motions = [...this.motions, {theta: this.moment.theta, E: this.moment.E, probe: false, shown: true}];
  }

  /** A motion by hand, which counts. @param {number[]} theta */
  move(theta) {
    if (this.motions.length > MAX_MOTIONS) return;
    this.observe(theta);
    this.motions = [...this.motions, {theta: this.moment.theta, E: this.moment.E, probe: false}];
    this.changed();
  }

  /** @param {number[]} theta of the demonstrator */
  pose(theta) {
    const own = this.moment.theta;
    this.session.pose(theta);
    this.observe(own);
  }

  /** What would be seen in the demonstrator's posture. */
  ghost() { return this.session.observe(this.moment.thetaDemo); }

  /** The demonstrator's points in L and R as the lines put them: (4 N) px. @param {Moment} [moment] */
  recovered(moment = this.moment) { return recovered(moment); }

  /** The epipolar geometry; null with too few points. @param {Moment} [moment] */
  geometry(moment = this.moment) { return geometry(moment); }

  /** The epipolar line of the chosen point of l (0) or r (1) in L (0) or R (1); null if there is none.
   * @param {number} eye @param {number} [side] @param {Moment} [moment] */
  line(eye, side = 0, moment = this.moment) {
    const [pointed, own] = [moment.views.demo, moment.views.own].map(images =>
      images.subarray(4 * this.chosen, 4 * this.chosen + 4));
    const lines = moment.usable.includes(this.chosen) ? this.geometry(moment)?.lines(pointed, own) ?? []
      : [];
    return lines.find(({into, from}) => into === 2 + side && from === eye) ?? null;
  }

  /** E over both joints, for the demonstrator as it is seen. @param {number} [stepDeg] */
  landscape(stepDeg = 1) { return stageMap(this, stepDeg).landscape; }

  /** The races of the step that are known, and how their servos are drawn and named. */
  get racing() {
    return (this.step.race ?? []).flatMap(servo => {
      const race = this.race(servo), [role, title] = RACERS[servo] ?? ["plain", servo];
      return race ? [{role, title, race}] : [];
    });
  }

  /** A servo's run from the step's start: recorded, or else computed here.
   * @param {string} servo @returns {Race | null} */
  race(servo) {
    if (this.records.races?.[servo]) return this.records.races[servo];
    if (!(servo in SERVOS)) return null;
    if (!this.raced[servo]) {
      const session = new Session(this.world, {...this.session.settings, servo}), goal = this.goal;
      const snapshots = [session.now];
      while (snapshots.length <= MAX_RACE && !(goal !== null && session.now.E < goal)
        && session.step()) snapshots.push(session.now);
      const [postures, E, probes] = [snapshots.map(({theta}) => theta), snapshots.map(one => one.E),
        snapshots.map(({probe}) => probe)];
      const status = snapshots.length > MAX_RACE ? "max-motions" : session.now.status; // "moving" where the goal is reached
      const claim = {status, seen: session.now.usable.length, unobservable: [], expectedOffDeg: null, swapped: []};
      this.raced[servo] = {postures, E, probes, claim};
    }
    return this.raced[servo];
  }

  /** The motion of a race that reaches the goal, or else its last one. @param {Race} race */
  last({E}) {
    const {goal} = this, at = goal === null ? -1 : E.findIndex(value => value < goal);
    return at < 0 ? E.length - 1 : at;
  }

  /** How many motions of a race are shown. @param {number} all */
  played(all) { return Math.round(this.reveal * (all - 1)); }

  /** Turn a slider, by its name: `own 1`, `demo 2`, `guess 1` are joints in degrees, `knob 1` turns both joints by the
   * random matrix, `pose apart` goes from the demonstrator's posture (0) to the start (1). Names of `variants` move the
   * eyes; noise_px, missing, seed and transfer are settings. Of any other name, the figures make what they know.
   * @param {string} name @param {number} value */
  slide(name, value) {
    this.sliders.set(name, value);
    const [kind, number] = name.split(" "), joint = Number(number) - 1, {moment} = this;
    const turned = (/** @type {number[]} */ theta) => theta.map((v, k) => k === joint ? value * DEGREE : v);
    if (kind === "own" && joint in moment.theta) this.observe(turned(moment.theta));
    else if (kind === "demo" && joint in moment.theta) this.pose(turned(moment.thetaDemo));
    else if (name === "pose apart") {
      const {start} = this.session.settings;
      this.observe(moment.thetaDemo.map((v, k) => v + value * (start[k] - v)));
    } else if (name in SETTINGS) {
      this.session.change({[SETTINGS[/** @type {keyof typeof SETTINGS} */ (name)]]: value});
      this.observe(moment.theta);
    } else if (this.variants[name]) this.#see(name, value);
    this.changed();
  }

  /** Joint angles that the guess sliders stand for, rad. */
  get guessed() {
    return this.moment.theta.map((v, k) => (this.sliders.get(`guess ${k + 1}`) ?? v / DEGREE) * DEGREE);
  }

  /** The posture to which both knobs turn the arm from here. */
  get knobbed() {
    const {lower, upper} = this.scene, turns = [1, 2].map(k => {
      const high = this.step.sliders?.find(({name}) => name === `knob ${k}`)?.high ?? 1;
      return (this.sliders.get(`knob ${k}`) ?? 0) / high;
    });
    return this.moment.theta.map((v, k) => clamp(v + turns[0] * this.knobs[0][k] + turns[1] * this.knobs[1][k],
      lower[k], upper[k]));
  }

  /** Other cameras, of a variant's value that is nearest. @param {string} name @param {number} value */
  #see(name, value) {
    const {theta, thetaDemo} = this.moment, isLogarithmic = this.step.sliders?.find(slider =>
      slider.name === name)?.logarithmic;
    const off = (/** @type {Variants[number]} */ one) =>
      Math.abs(isLogarithmic ? Math.log(one.value / value) : one.value - value);
    const {cameras} = this.variants[name].reduce((a, b) => off(b) < off(a) ? b : a);
    this.world = new World({...this.scene, cameras}, this.state.points);
    this.session = new Session(this.world, {...this.session.settings, demonstrator: thetaDemo});
    this.observe(theta);
  }

  /** @param {Slider} slider */
  #standing({name, start}) {
    const [kind, number] = name.split(" "), joint = Number(number) - 1, {theta, thetaDemo} = this.moment;
    const from = kind === "demo" ? thetaDemo : kind === "own" ? theta : null;
    return from && joint in from ? Math.round(from[joint] / DEGREE * 1000) / 1000 : start;
  }
}

/** Which joint each knob turns, how far and which way round. @param {number} seed */
function randomKnobs(seed) {
  const draw = draws(seed), gain = () => (draw() < .5 ? -1 : 1) * KNOB_RAD * (KNOB_GAINS[0]
    + draw() * (KNOB_GAINS[1] - KNOB_GAINS[0]));
  const both = [[gain(), 0], [0, gain()]];
  return draw() < .5 ? both : both.reverse();
}

/** The numbers from 0 to count - 1 in an order that a seed gives. @param {number} count @param {number} seed */
export function shuffledOrder(count, seed) {
  const draw = draws(seed), order = Array.from({length: count}, (_, k) => k);
  for (let k = count - 1; k > 0; k--) {
    const other = Math.floor(draw() * (k + 1));
    [order[k], order[other]] = [order[other], order[k]];
  }
  return order;
}
