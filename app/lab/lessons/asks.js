/** What a step asks for, as something to press: answers, a number, a goal, predictions, a bet. A mark in a
 * figure is made in marks.js, sliders are made in sliders-row.js.
 * @import {Stage} from "./stage.js"
 * @typedef {{element: HTMLElement, update: () => void, key?: (key: string) => boolean}} Asked key: whether it has
 * taken the key
 * @typedef {{answered: () => void, startAgain: () => void, isLocked: () => boolean, bar: (k: number) => {count:
 * number, share: number} | null}} Host what the page does about it; bar: how many of a class have given an answer */
import {isAnswered, isReached, rightChoice} from "./answers.js";
import {inline, isTouched, make, option, plain, slider, touched} from "./dom.js";
import {fill, measure} from "./measures.js";
import {energy, short} from "./measured.js";

const BET_STEP = 5;

/** @type {Record<string, (stage: Stage, host: Host) => Asked>} */
const KINDS = {choice, place, pose, number, do: task, predict, bet};

/** @param {Stage} stage @param {Host} host */
export function askOf(stage, host) {
  const {ask} = stage.step, asked = KINDS[ask.kind](stage, host), {glossary} = stage.page;
  const element = make("section", {class: `ask ask-${ask.kind}`, "aria-label": "Question"},
    make("p", {class: "question", html: inline(fill(ask.question, stage), glossary)}), asked.element);
  return {...asked, element};
}

/** @param {Stage} stage @param {Host} host @returns {Asked} */
function choice(stage, host) {
  const {answers = []} = stage.step.ask;
  const take = (/** @type {number} */ k) => {
    if (stage.isRevealed || host.isLocked()) return;
    stage.answer = {choice: k};
    host.answered();
  };
  const options = answers.map(({text}, k) => option(String(k + 1), inline(fill(text, stage)), () => take(k),
    make("i", {class: "verdict", "aria-hidden": true}), make("span", {class: "unseen"}),
    make("i", {class: "bar", "aria-hidden": true}), make("small", {class: "count"})));
  return {
    element: make("div", {class: "options", role: "group", "aria-label": "Answers"}, ...options),
    update() {
      const right = stage.isRevealed ? rightChoice(stage) : -1;
      options.forEach((one, k) => {
        const isChosen = stage.answer.choice === k, bar = host.bar(k);
        one.setAttribute("aria-pressed", String(isChosen));
        one.disabled = host.isLocked() && !stage.isRevealed;
        one.setAttribute("aria-disabled", String(stage.isRevealed));
        one.className = `option${isChosen ? " chosen" : ""}${stage.isRevealed ? k === right ? " right" : isChosen ? " wrong" : " other" : ""}`;
        one.querySelector(".verdict")?.replaceChildren(stage.isRevealed ? k === right ? "✓" : isChosen ? "✗" : ""
          : "");
        const verdict = !stage.isRevealed ? "" : k === right ? " (right)" : isChosen ? " (your answer, not right)" : "";
        one.querySelector(".unseen")?.replaceChildren(verdict);
        one.style.setProperty("--share", bar ? String(bar.share) : "0");
        one.querySelector(".count")?.replaceChildren(bar ? `${bar.count} · ${Math.round(100 * bar.share)} %` : "");
      });
    },
    key(key) {
      const k = Number(key) - 1;
      if (!(k in options)) return false;
      take(k);
      return true;
    },
  };
}

/** @param {Stage} stage @returns {Asked} */
function place(stage) {
  const hint = make("p", {class: "hint"});
  return {
    element: hint,
    update() {
      hint.hidden = stage.isRevealed;
      hint.textContent = stage.mark ? isTouched() ? "Tap again to move your mark."
        : "Click again to move your mark, or use the arrow keys."
        : isTouched() ? "Tap in the framed picture." : "Click in the framed picture, or use the arrow keys.";
    },
  };
}

/** @param {Stage} stage @returns {Asked} */
function pose(stage) {
  const hint = make("p", {class: "hint"}, "Turn both joints with the sliders.");
  return {element: hint, update() { hint.hidden = stage.isRevealed; }};
}

/** @param {Stage} stage @param {Host} host @returns {Asked} */
function number(stage, host) {
  const {low = 0, high = 1, step, logarithmic, unit = "", question} = stage.step.ask;
  const round = (/** @type {number} */ value) => step && !logarithmic
    ? Number((low + Math.round((value - low) / step) * step).toPrecision(12)) : Number(value.toPrecision(2));
  const middle = logarithmic ? Math.sqrt(low * high) : (low + high) / 2, output = make("output", {class: "large-number"});
  const {input, read, show} = slider({label: plain(fill(question, stage)), low, high, step, logarithmic}, value => {
    stage.answer = {number: Math.min(high, Math.max(low, round(value)))};
    host.answered();
  });
  return {
    element: make("div", {class: "number"}, output, input, ends(`${low}${unit}`, `${high}${unit}`)),
    update() {
      const {number: value} = stage.answer, words = value === undefined ? "?"
        : `${short(value).replace(/\.0+$/, "")}${unit}`;
      output.textContent = words;
      show(document.activeElement === input ? read() : value ?? middle, words, stage.isRevealed || host.isLocked());
    },
  };
}

/** What stands under a slider. @param {...string} words */
const ends = (...words) => make("div", {class: "ends", "aria-hidden": true}, ...words.map(one => make("span", {}, one)));

/** Something to be reached. @param {Stage} stage @param {Host} host @returns {Asked} */
function task(stage, host) {
  const {ask} = stage.step, goal = ask.below ?? ask.above ?? 0, isBelow = ask.below !== null && ask.below !== undefined;
  const now = make("b", {}), filled = make("i", {}), count = make("span", {});
  const again = make("button", {type: "button", class: "plain small", onclick: host.startAgain}, "Start again");
  const first = Number(measure(stage, ask.measure ?? "").value), unit = measure(stage, ask.measure ?? "").unit;
  const start = Math.max(ask.measure === "E" ? stage.motions[0].E : first, goal * 1.01);
  const text = (/** @type {number} */ value) => ask.measure === "E" ? energy(value).text : `${short(value)}${unit}`;
  return {
    element: make("div", {class: "task"}, make("p", {class: "now"}, now,
      make("span", {class: "goal"}, ` goal: ${isBelow ? "below" : "above"} ${text(goal)}`)),
      make("div", {class: "meter", "aria-hidden": true}, filled), make("p", {class: "steps-made"}, count, again)),
    update() {
      const {value, text: words} = measure(stage, ask.measure ?? ""), {steps} = stage;
      const share = isBelow ? Math.log(start / Math.max(value, 1e-9)) / Math.log(start / goal) : value / goal;
      now.textContent = words;
      now.classList.toggle("there", isReached(stage));
      filled.style.width = `${100 * Math.min(1, Math.max(0, share))}%`;
      count.textContent = ask.counted ? `${steps} ${steps === 1 ? "step" : "steps"}` : "";
      again.hidden = !ask.counted || steps === 0 || host.isLocked();
    },
  };
}

/** @param {Stage} stage @returns {Asked} */
function predict(stage) {
  const hint = make("p", {class: "hint"}), says = make("p", {class: "prediction", role: "status"});
  return {
    element: make("div", {class: "predict"}, says, hint),
    update() {
      const last = stage.rounds[stage.rounds.length - 1], {measure: name = "", below} = stage.step.ask;
      hint.hidden = stage.isRevealed || isSet(stage);
      hint.textContent = !isSet(stage) ? touched(stage.mark ? "Now set a knob."
        : "Set a knob, then click where the ringed dot will go.") : "";
      if (!last) return void says.replaceChildren();
      const off = Math.hypot(last.mark[0] - last.to[0], last.mark[1] - last.to[1]),
        far = Math.hypot(last.to[0] - last.from[0], last.to[1] - last.from[1]);
      says.replaceChildren(`Your prediction was `, make("b", {}, `${short(off)} px`),
        ` off; the dot moved ${short(far)} px. `,
        `To the goal: ${measure(stage, name ?? "").text}${below ? ` (goal: below ${below})` : ""}.`);
    },
  };
}

/** Whether a knob and the mark are set, so that the arm may turn. @param {Stage} stage */
export const isSet = stage => Boolean(stage.mark) && [...stage.sliders].some(([name, value]) =>
  name.startsWith("knob ") && Math.abs(value) > 1e-6);

/** @param {Stage} stage @param {Host} host @returns {Asked} */
function bet(stage, host) {
  const output = make("output", {class: "large-number"}), which = make("p", {class: "hint"});
  const {input, show} = slider({label: "How sure you are that it is true", low: 0, high: 100, step: BET_STEP}, bet => {
    stage.answer = {bet};
    host.answered();
  });
  return {
    element: make("div", {class: "number"}, which, output, input, ends("surely false", "no idea", "surely true")),
    update() {
      const words = isAnswered(stage) && stage.answer.bet !== undefined ? `${stage.answer.bet} %` : "?";
      output.textContent = words;
      which.textContent = stage.runs > 1 ? `Run ${stage.run + 1} of ${stage.runs}` : "";
      which.hidden = stage.runs < 2;
      show(stage.answer.bet ?? 50, words, stage.isRevealed || host.isLocked());
    },
    key(key) {
      if (!/^[0-9]$/.test(key) || stage.isRevealed) return false;
      stage.answer = {bet: Number(key) * 10};
      host.answered();
      return true;
    },
  };
}
