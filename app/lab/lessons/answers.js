/** Whether an answer is there, whether it is right, and the reply to it. @import {Stage, Ask} from "./stage.js" */
import {distanceOf, judged} from "./measures.js";

const CLEAR_BET = 10; // % from the middle, from which a bet says something

/** Whether the truth may be shown after the answer. @param {Stage} stage */
export function isAnswered({step: {ask}, answer, rounds, mark}) {
  if (ask.kind === "choice") return answer.choice !== undefined;
  if (ask.kind === "place") return Boolean(mark);
  if (ask.kind === "pose") return Boolean(answer.pose);
  if (ask.kind === "number") return answer.number !== undefined;
  if (ask.kind === "bet") return answer.bet !== undefined;
  if (ask.kind === "predict") return rounds.length > 0;
  return Boolean(answer.done);
}

/** The index of a choice's right answer; -1 while it is not known. @param {Stage} stage */
export function rightChoice(stage) {
  const {ask} = stage.step;
  if (!ask.right) return (ask.answers ?? []).findIndex(({right}) => right);
  const number = Number(judged(stage, ask.right).value);
  return Number.isFinite(number) ? Math.round(number) - 1 : -1;
}

/** Whether what has to be reached is. @param {Stage} stage */
export function isReached(stage) {
  const {ask: {measure: name, below, above}} = stage.step, value = Number(judged(stage, name ?? "").value);
  return below !== null && below !== undefined && value < below || above !== null && above !== undefined
    && value > above;
}

/** How many rounds a step has at most; 1 of the kinds that have none. @param {Ask} ask */
export const roundsOf = ({times}) => times ?? 1;

/** Whether the rounds of predictions are over: the goal is reached, or all are made. @param {Stage} stage */
export const arePlayed = stage => stage.rounds.length > 0
  && (isReached(stage) || stage.rounds.length >= roundsOf(stage.step.ask));

/** @param {Ask} ask @param {number} number @param {number} truth */
export function isNear({factor, within}, number, truth) {
  return factor ? truth > 0 && number / truth <= factor && truth / number <= factor
    : Math.abs(number - truth) <= (within ?? 0);
}

/** Why an answer is right, for all, as on paper and on a projector: its reply without the first sentence, which is for
 * who gave it. @param {Ask} ask */
export const reasonOf = ({close = ""}) => close.replace(/^.*?[.!?](\s+(?=[A-Z{])|\s*$)/, "");

/** The other place that was marked, which has a reply of its own. @param {Stage} stage */
const elsewhereOf = stage => stage.mark && stage.step.ask.elsewhere?.find(one => distanceOf(stage, one.truth) <= one.near);

/** Whether the answer is right, or near enough to be called so; null without one, or where there is no right one.
 * @param {Stage} stage */
export function isRight(stage) {
  const {step: {ask}, answer} = stage;
  if (!isAnswered(stage) || answer.shown) return null;
  if (ask.kind === "choice") return answer.choice === rightChoice(stage);
  if (ask.kind === "place" || ask.kind === "pose") {
    if (elsewhereOf(stage)) return false;
    const off = Number(judged(stage, "distance in px").value);
    return Number.isNaN(off) ? null : off <= (ask.near ?? 0);
  }
  if (ask.kind === "number") return isNear(ask, /** @type {number} */ (answer.number),
    Number(judged(stage, ask.truth ?? "").value));
  if (ask.kind === "do") return true;
  if (ask.kind === "predict") return isReached(stage);
  if (ask.kind === "bet") {
    const off = /** @type {number} */ (answer.bet) - 50;
    return Math.abs(off) < CLEAR_BET ? null : off > 0 === Boolean(judged(stage, ask.truth ?? "").value);
  }
  return null;
}

/** The reply to this very answer, with its {measures}; "" for nothing. @param {Stage} stage */
export function reply(stage) {
  const {step: {ask}, answer} = stage;
  if (!isAnswered(stage) || answer.shown) return "";
  if (ask.kind === "choice") return ask.answers?.[answer.choice ?? -1]?.because ?? "";
  if (ask.kind === "place" || ask.kind === "pose") {
    const other = elsewhereOf(stage);
    if (other) return other.because;
    if (isRight(stage)) return ask.close ?? "";
    const isOnLine = ask.line && ask.on_line && Number(judged(stage, ask.line).value) < (ask.near ?? 0);
    return (isOnLine ? ask.on_line : ask.far) ?? "";
  }
  if (ask.kind === "number") {
    const truth = Number(judged(stage, ask.truth ?? "").value), number = /** @type {number} */ (answer.number);
    return (isNear(ask, number, truth) ? ask.close : ask.less && number < truth ? ask.less : ask.far) ?? "";
  }
  return "";
}
