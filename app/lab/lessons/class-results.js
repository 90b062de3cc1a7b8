/** What a class has answered, drawn: bars of choices, a histogram of numbers, a cloud of postures; and who moved.
 * @import {Results, Tally, Moved, Asked} from "./class.js"
 * @typedef {{asked: Asked, question: any, stage: any, isNarrow: boolean}} About question: one
 * of the eight, null for a step; isNarrow: on a phone, where the answers' own bars have to do */
import {isRight, reasonOf, rightChoice} from "./answers.js";
import {inline, make} from "./dom.js";
import {fill, measure} from "./measures.js";
import {escaped} from "../view/svg.js";

const MAX_BINS = 14, DEGREE = Math.PI / 180;
const WIDTH = 300, HEIGHT = 96, FOOT = 18; // of a histogram
const MAP = {width: 300, height: 190, left: 34, bottom: 20}; // of a cloud of postures

/** @param {Results} results @param {About} about */
export function resultsOf(results, about) {
  const {asked} = about, {now, before, first} = results, rounds = [now, ...before ? [before] : [], ...first ? [first] : []];
  const names = rounds.length === 3 ? ["now", "round before", "first round"] : ["now", "first round"];
  const ask = about.question ? {kind: "choice"} : about.stage?.step.ask ?? {};
  const drawn = make("div", {class: "class-drawn"}), said = make("div", {class: "class-words"}, make("p", {class: "class-n"}, ...summary(now, asked.revealed)));
  if (asked.left_out) said.append(make("p", {class: "hint"}, `Left out: ${asked.left_out} ${asked.left_out === 1 ? "answer" : "answers"} of pages that left at once, or more than students were here from one network.`));
  if (rounds.length > 1) said.append(make("p", {class: "class-key"}, ...rounds.map((one, k) =>
    make("span", {class: `round-${k}`}, `${names[k]}, n = ${one.total}${asked.revealed && one.right !== null ? `, ${share(one.right, one.total)} right` : ""}`))));
  if (asked.revealed && ask.kind !== "choice") { // of a choice, question and reasons stay in the card
    said.prepend(make("p", {class: "class-question", html: inline(ask.question)}));
    if (reasonOf(ask) && isRight(about.stage) !== true) said.append(make("p", {html: inline(fill(reasonOf(ask), about.stage))}));
  }
  if (asked.revealed) {
    if (results.moved) said.append(movedOf(results.moved, first ? "Since the round before" : "Since the first round"));
    if (results.moved_since_first) said.append(movedOf(results.moved_since_first, "Since the first round"));
  }
  if (ask.kind === "choice") {
    if (about.question || rounds.length > 1 || !about.isNarrow) drawn.append(bars(rounds, about)); // else they stand in the card
  } else if (ask.kind === "pose") drawn.append(cloud(now.values, about));
  else if (ask.kind === "place") said.append(make("p", {class: "hint"}, "Each cross in the picture is one answer."));
  else if (ask.kind === "predict") drawn.append(histogram(now.values.map(one => one.length), {unit: " rounds", truth: null}));
  else if (ask.kind === "bet" && now.values.some(one => one.length > 1)) drawn.append(bets(now.values));
  else drawn.append(histogram(now.values.map(one => one[0]), {unit: ask.kind === "do" ? " steps" : ask.unit ?? (ask.kind === "bet" ? " %" : ""),
    truth: asked.revealed && ask.kind === "number" ? Number(measure(about.stage, ask.truth).value) : null}));
  return make("div", {class: "class-results"}, drawn.childElementCount ? drawn : null, said);
}

/** @param {Tally} now @param {boolean} isRevealed */
function summary({total, right}, isRevealed) {
  const count = make("b", {}, `${total} ${total === 1 ? "answer" : "answers"}`);
  return isRevealed && right !== null && total ? [count, `: ${right} of ${total} right (${share(right, total)})`] : [count];
}

/** @param {number} part @param {number} all */
const share = (part, all) => all ? `${Math.round(100 * part / all)} %` : "–";

/** @param {Tally[]} rounds @param {About} about */
function bars(rounds, {asked, question, stage}) {
  const answers = question?.answers ?? stage?.step.ask.answers ?? [];
  const right = !asked.revealed ? -1 : question ? answers.findIndex((/** @type {any} */ one) => one.right) : rightChoice(stage);
  return make("ol", {class: `class-bars${question ? " with-words" : ""}`}, ...answers.map((/** @type {any} */ {text, because}, /** @type {number} */ k) => {
    const counts = rounds.map(({counts}) => counts[k] ?? 0), words = `${counts[0]} of ${rounds[0].total}`;
    return make("li", {class: k === right ? "right" : ""},
      question ? make("span", {class: "words", html: inline(text)}) : make("span", {class: "digit", title: text}, String(k + 1)),
      make("span", {class: "pair"}, ...rounds.map(({total}, at) => make("i", {class: `round-${at}`, style: `--share:${total ? counts[at] / total : 0}`}))),
      make("span", {class: "of"}, `${words}${rounds[0].total ? `, ${share(counts[0], rounds[0].total)}` : ""}${k === right ? " ✓" : ""}`),
      k === right && (question || stage.answer.choice !== k) ? make("small", {html: inline(question ? because : fill(because, stage))}) : null);
  }));
}

/** @param {number[]} values @param {{unit: string, truth: number | null}} how */
function histogram(values, {unit, truth}) {
  const found = values.filter(Number.isFinite), all = truth === null || !Number.isFinite(truth) ? found : [...found, truth];
  if (!all.length) return make("p", {class: "hint"}, "No answer yet.");
  const low = Math.min(...all), high = Math.max(...all), isWhole = found.every(Number.isInteger) && high - low < MAX_BINS;
  const bins = isWhole ? high - low + 1 : Math.min(MAX_BINS, Math.max(4, Math.ceil(Math.sqrt(found.length)) + 1));
  const width = isWhole ? 1 : (high - low) / bins || 1, counts = new Array(bins).fill(0);
  for (const value of found) counts[Math.min(bins - 1, Math.floor((value - low) / width))]++;
  const most = Math.max(1, ...counts), step = WIDTH / bins, top = 16, tall = HEIGHT - FOOT - top;
  const x = (/** @type {number} */ value) => isWhole ? (value - low + .5) * step : (value - low) / width * step;
  const columns = counts.map((count, k) => count ? `<rect class="round-0" x="${(k * step + 1.5).toFixed(1)}" width="${(step - 3).toFixed(1)}" y="${(top + tall * (1 - count / most)).toFixed(1)}" height="${(tall * count / most).toFixed(1)}"/>
<text x="${((k + .5) * step).toFixed(1)}" y="${(top + tall * (1 - count / most) - 4).toFixed(1)}" text-anchor="middle">${count}</text>` : "").join("");
  const ticks = (isWhole ? counts.map((_, k) => low + k) : [low, (low + high) / 2, high]).map((value, k, {length}) =>
    length > 8 && k % 2 ? "" : `<text class="tick" x="${x(value).toFixed(1)}" y="${HEIGHT - 3}" text-anchor="${isWhole ? "middle" : k === 0 ? "start" : k === length - 1 ? "end" : "middle"}">${number(value)}</text>`).join("");
  const mark = truth !== null && Number.isFinite(truth) ? `<path class="truth" d="M${x(truth).toFixed(1)} ${top - 8}V${HEIGHT - FOOT}"/>` : "";
  const words = `${found.length} answers from ${number(low)} to ${number(high)}${unit}`;
  return make("figure", {class: "class-histogram", html: `<svg viewBox="0 0 ${WIDTH} ${HEIGHT}" role="img" aria-label="${escaped(words)}">${columns}<path class="axis" d="M0 ${HEIGHT - FOOT}H${WIDTH}"/>${mark}${ticks}</svg>
<figcaption>${mark ? `The line: ${number(/** @type {number} */ (truth))}${escaped(unit)}` : escaped(unit.trim())}</figcaption>`});
}

/** @param {number} value */
const number = value => (Math.abs(value) >= 100 || Number.isInteger(value) ? String(Math.round(value)) : value.toPrecision(2)).replace("-", "−");

/** Postures in the plane of both joints, in degrees. @param {number[][]} values @param {About} about */
function cloud(values, {asked, stage}) {
  const {lower, upper, names} = stage.scene, {width, height, left, bottom} = MAP, degrees = [lower, upper].map(ends => ends.map((/** @type {number} */ v) => v / DEGREE));
  const at = (/** @type {number[]} */ [a, b]) => [left + (b - degrees[0][1]) / (degrees[1][1] - degrees[0][1]) * (width - left - 6),
    6 + (degrees[1][0] - a) / (degrees[1][0] - degrees[0][0]) * (height - bottom - 6)].map(v => v.toFixed(1));
  const crosses = values.map(one => at(one)).map(([x, y]) => `<path class="cross" d="M${x} ${y}m-4-4l8 8m0-8l-8 8"/>`).join("");
  const truth = asked.revealed && stage.step.ask.truth ? measure(stage, stage.step.ask.truth).value : null;
  const goal = truth?.length === 2 ? at(truth) : null;
  return make("figure", {class: "class-cloud", html: `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="${values.length} postures">
<rect class="frame" x="${left}" y="6" width="${width - left - 6}" height="${height - bottom - 6}"/>${crosses}${goal ? `<path class="truth" d="M${goal[0]} ${goal[1]}m-7 0h14m-7-7v14"/>` : ""}
${[0, 1].map(end => `<text x="${end ? width - 6 : left}" y="${height - 4}" text-anchor="${end ? "end" : "start"}">${number(degrees[end][1])}°</text><text x="${left - 4}" y="${end ? 16 : height - bottom}" text-anchor="end">${number(degrees[end][0])}°</text>`).join("")}
<text x="${(left + width) / 2}" y="${height - 4}" text-anchor="middle">${escaped(names[1])}</text><text transform="translate(12 ${height / 2}) rotate(-90)" text-anchor="middle">${escaped(names[0])}</text></svg>`});
}

/** The mean bet on each run. @param {number[][]} values */
function bets(values) {
  const runs = Math.max(...values.map(one => one.length));
  return make("ol", {class: `class-bars${runs > 5 ? " in-columns" : ""}`}, ...Array.from({length: runs}, (_, k) => {
    const found = values.map(one => one[k]).filter(Number.isFinite), mean = found.reduce((sum, one) => sum + one, 0) / (found.length || 1);
    return make("li", {}, make("span", {class: "digit"}, String(k + 1)), make("span", {class: "pair"}, make("i", {class: "round-0", style: `--share:${mean / 100}`})),
      make("span", {class: "of"}, `mean ${Math.round(mean)} %, n = ${found.length}`));
  }));
}

/** @param {Moved} moved @param {string} since */
function movedOf({right, gained, lost, wrong}, since) {
  const total = right + gained + lost + wrong;
  const part = (/** @type {number} */ count, /** @type {string} */ kind) => count ? make("i", {class: kind, style: `flex:${count}`}, String(count)) : null;
  return make("div", {class: "class-moved"},
    make("p", {}, `${since}, of the ${total} who answered both times: `, make("b", {}, `${gained} from wrong to right`), `, ${lost} from right to wrong, ${right} right twice, ${wrong} wrong twice.`),
    make("p", {class: "moves", "aria-hidden": "true"}, part(right, "kept"), part(gained, "gained"), part(lost, "lost"), part(wrong, "missed")));
}
