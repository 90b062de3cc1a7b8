/** The card of a step: its words, what it asks, and after the answer a reply, a number in large and a sentence to say.
 * @import {Stage} from "./stage.js" @import {Host} from "./asks.js" */
import {isAnswered, isRight, reply} from "./answers.js";
import {askOf} from "./asks.js";
import {inline, make, plain} from "./dom.js";
import {fill, judged, measure} from "./measures.js";

/** What is said to who has pressed "Show me" instead of an answer. */
const STUCK = "Here is how it is. Before the next step, commit to a guess: you will remember more.";
const STUCK_AT = /** @type {Record<string, string>} */ ({do: "This is one way to reach the goal.",
  predict: "There is nothing to compare without a turn. Begin again, and make some."});

/** Words without what they would say of an earlier step that was not played.
 * @param {string} words @param {Stage} stage */
export function playedOnly(words, stage) {
  const isOpen = (/** @type {string} */ part) => [...part.matchAll(/\{(your [^}]*)\}/g)].some(([, name]) =>
    judged(stage, name).text === "–");
  if (!isOpen(words)) return words;
  const left = words.split(/(?<=[.!?])\s+/).map(sentence => isOpen(sentence)
    ? sentence.replace(/you \{your [^}]*\}, /, "") : sentence).filter(sentence => !isOpen(sentence));
  const played = stage.previous ? `“${stage.previous.step.title}”` : "this step";
  return [...left, stage.steps ? `You did not reach the goal of ${played}.` : `You have not played ${played}.`].join(" ");
}

export class Card {
  /** @param {HTMLElement} box @param {Stage} stage @param {Host} host */
  constructor(box, stage, host) {
    this.box = box;
    this.stage = stage;
    this.host = host;
    const {step, page} = stage;
    this.words = make("p", {class: "text"});
    this.ask = askOf(stage, host);
    this.headline = make("div", {class: "headline"});
    this.reply = make("p", {class: "reply"});
    this.after = make("p", {class: "after"});
    this.say = make("div", {class: "say"});
    this.glossary = page.glossary ?? {};
    box.replaceChildren(make("h2", {tabindex: -1, html: inline(step.title)}), this.words, this.ask.element, this.headline,
      this.reply, this.after, this.say);
    this.last = /** @type {Map<HTMLElement, string>} */ (new Map());
  }

  update() {
    const {stage} = this, {step, answer} = stage, isShown = stage.isRevealed;
    this.#write(this.words, isShown ? "" : inline(fill(playedOnly(step.text, stage), stage), this.glossary));
    this.ask.update();
    this.ask.element.hidden = isShown && !["choice", "predict"].includes(step.ask.kind)
      || Boolean(isShown && step.ask.kind === "predict" && !stage.rounds.length);
    this.#write(this.headline, isShown ? this.#headline() : "");
    const said = isShown ? answer.shown ? STUCK_AT[step.ask.kind] ?? STUCK : reply(stage) : "";
    this.#write(this.reply, inline(fill(said, stage), this.glossary));
    const isOwn = answer.shown && (step.ask.kind === "predict" || /\{your /.test(step.after ?? "")); // it would speak of an answer that was not given
    this.#write(this.after, isShown && step.after && !isOwn ? inline(fill(playedOnly(step.after, stage), stage),
      this.glossary) : "");
    this.#write(this.say, isShown ? `<small>Now you can say</small>${inline(fill(step.say, stage), this.glossary)}`
      : "");
    this.box.classList.toggle("revealed", isShown);
  }

  /** Whether there is what its large number is about. */
  get #isHeadlined() {
    return isAnswered(this.stage) || !["place", "pose", "bet"].includes(this.stage.step.ask.kind);
  }

  /** A number in large, where there is an answer that it is about. */
  #headline() {
    const {headline} = this.stage.step;
    if (!headline || !this.#isHeadlined) return "";
    const {text} = judged(this.stage, headline.measure), [, number, unit] = text.match(/^([−\d.,]+)\s?(.*)$/)
      ?? ["", text, ""];
    const note = headline.note ? `<small>${inline(fill(headline.note, this.stage), this.glossary)}</small>` : "";
    const isDegrees = unit.startsWith("°"), suffix = headline.measure.startsWith("distance in ")
      ? `${isDegrees ? "" : `${unit} `}apart` : isDegrees ? "" : unit;
    return `<span>${inline(fill(headline.label, this.stage))}</span><strong>${number}${isDegrees ? "°" : ""}<i>${suffix}</i></strong>${note}`;
  }

  /** The news that is read aloud, and not the whole card. */
  spoken() {
    const {stage} = this, {step} = stage;
    if (!stage.isRevealed) return step.ask.kind === "do"
      ? `${step.ask.measure} ${measure(stage, step.ask.measure ?? "").text}, ${stage.steps} steps` : "";
    const verdict = {true: "Right.", false: "Not quite.", null: ""}[String(isRight(stage))] ?? "";
    const label = plain(fill(step.headline?.label ?? "", stage)).replace(/:$/, "");
    const number = step.headline && this.#isHeadlined ? `${label}: ${judged(stage, step.headline.measure).text}.` : "";
    const replied = plain(fill(reply(stage), stage));
    return [replied.startsWith("Right") ? "" : verdict, number, replied, "Now you can say:",
      plain(fill(step.say, stage))].filter(Boolean).join(" ");
  }

  /** @param {HTMLElement} element @param {string} html */
  #write(element, html) {
    if (this.last.get(element) === html) return;
    this.last.set(element, html);
    element.innerHTML = html;
    element.hidden = !html;
  }
}
