/**
 * The visitor's choice against the page's own, from the same starts: how far each ended from the demonstrator, and
 * what came of all choices so far.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").FigureKind} FigureKind
 * @typedef {[number, number][]} Runs degrees off at the end, and motions made, from each start
 * @typedef {{starts: number, motions: number, withinDeg: number, page: string, runs: Record<string, Runs>}} Rounds by
 *   "transfer/servo"
 * @typedef {{scene: number, what: string, yours: number, pages: number}} Result
 */
import {px} from "../../view/svg.js";
import {named, table} from "./cards.js";
import {axis, diamonds, dots, Drawing, legend, path, polyline, text} from "./drawing.js";
import {part} from "./panels.js";
import {short} from "../measured.js";

const LOW = .01, HIGH = 180, DEGREES = [.01, .1, 1, 10, 100];
const LEFT = 44, TOP = 54, FOOT = 38, RIGHT = 10, EVERY = 5;
const MOST_SHOWN = 8; // results, the newest

/** @type {FigureKind} */
export const ROUNDS = {
  layers: ["runs"],
  title: "Off the demonstrator at the end, in degrees",
  aspect: 1.1,
  create(box) {
    box.classList.add("bare", "lesson-rounds");
    const drawing = new Drawing(part(box, "lesson-plain"), ""), table = part(box, "lesson-table");
    return {
      resize: () => drawing.measure(),
      draw(stage, layers) {
        const rounds = roundsOf(stage), yours = layers.has("runs") ? chosenRuns(stage) : null;
        drawing.show(drawn(drawing, rounds, yours), described(rounds, yours));
        table.innerHTML = standing(rounds, yours);
      },
    };
  },
};

/** @type {FigureKind} */
export const RESULTS = {
  layers: [],
  title: "Your results so far",
  aspect: 2,
  create(box) {
    named(box, "lesson-table", "Your results so far");
    return {
      draw(stage) {
        const rows = resultsOf(stage).slice(-MOST_SHOWN).reverse().map(({scene, what, yours, pages}) =>
          [`scene ${scene}: ${what}`, String(yours), String(pages)]);
        box.innerHTML = rows.length ? table(["choice", "you there", "the page there"], rows)
          : '<p class="lesson-waits">No result yet.</p>';
      },
    };
  },
};

/** @param {Stage} stage @returns {Rounds} */
export const roundsOf = stage => stage.records.rounds;

/** Values of the fields that are selected; null until all of them are. @param {Stage} stage */
function selected({step: {ask}, answer}) {
  const values = (ask.fields ?? []).map(({values: all}, k) => all[answer.selected?.[k] ?? -1]);
  return values.length && values.every(Boolean) ? values : null;
}

/** Of the selection; null where it is not known. @param {Stage} stage @returns {Runs | null} */
export function chosenRuns(stage) {
  const values = selected(stage);
  return values && roundsOf(stage).runs[values.map(({value}) => value).join("/")] || null;
}

/** From how many starts the demonstrator's posture was reached. @param {Rounds} rounds @param {Runs} runs */
export const there = ({withinDeg}, runs) => runs.filter(([off]) => off <= withinDeg).length;

/** @type {Map<string, Result>} */
const seen = new Map();

/** All results while the page is open, of this stage too. @param {Stage} stage */
function resultsOf(stage) {
  const values = selected(stage), yours = chosenRuns(stage), rounds = roundsOf(stage);
  if (stage.isRevealed && values && yours) {
    const what = values.map(value => value.text).join(", "), key = `${stage.seed} ${what}`;
    seen.delete(key);
    const pages = there(rounds, rounds.runs[rounds.page]);
    seen.set(key, {scene: stage.seed, what, yours: there(rounds, yours), pages});
  }
  return [...seen.values()];
}

/** @param {Drawing} drawing @param {Rounds} rounds @param {Runs | null} yours */
function drawn({width, height}, rounds, yours) {
  const right = width - RIGHT, bottom = height - FOOT, pages = rounds.runs[rounds.page];
  const x = axis(.4, rounds.starts + .6, LEFT, right), y = axis(LOW, HIGH, bottom, TOP, true);
  const at = (/** @type {Runs} */ runs) => runs.map(([off], k) => [x(k + 1), y(Math.min(Math.max(off, LOW), HIGH))]);
  const starts = Array.from({length: rounds.starts}, (_, k) => k + 1).filter(k => k === 1 || k % EVERY === 0);
  let svg = path("vi-rule", DEGREES.map(v => `M${LEFT} ${px(y(v))}H${px(right)}`).join(""));
  svg += DEGREES.map(v => text(LEFT - 6, y(v) + 4.5, `${v}°`, "vi-2nd vi-end")).join("");
  svg += starts.map(k => text(x(k), bottom + 16, String(k), "vi-2nd vi-mid")).join("");
  svg += text((LEFT + right) / 2, bottom + 32, "start", "vi-2nd vi-mid");
  svg += path("lesson-goal", `M${LEFT} ${px(y(rounds.withinDeg))}H${px(right)}`);
  const middle = [(LEFT + right) / 2, (TOP + y(rounds.withinDeg)) / 2];
  if (!yours) svg += text(middle[0], middle[1], `both from the same ${rounds.starts} starts`, "vi-2nd vi-mid vi-halo");
  else {
    const [a, b] = [at(yours), at(pages)];
    svg += path("lesson-round-link", a.map((p, k) => polyline([p, b[k]])).join(""));
    svg += path("lesson-round-page", dots(b)) + path("lesson-round-you", diamonds(a, 5.5));
  }
  return svg + legend([
    [path("lesson-round-you", diamonds([[15, 0]], 5.5)), "your choice", "vi-b"],
    [path("lesson-round-page", dots([[15, 0]])), "the page's choice", "vi-b lesson-way-learner-words"],
    [path("lesson-goal", "M0 0h30"), `within ${rounds.withinDeg}°: there`, "vi-b lesson-there"],
  ], 0, 12, width).drawn;
}

/** @param {Rounds} rounds @param {Runs | null} yours */
function standing(rounds, yours) {
  /** @type {[string, Runs | null][]} */
  const both = [["your choice", yours], ["the page's choice", yours && rounds.runs[rounds.page]]];
  const rows = both.map(([name, runs]) => runs ? [
    name, `${there(rounds, runs)} of ${runs.length}`, `${short(median(runs.map(([off]) => off)))}°`,
    String(Math.round(median(runs.map(([, motions]) => motions)))),
  ] : [name, "–", "–", "–"]);
  return table([`${rounds.motions} motions at most`, "there", "off, median", "motions, median"], rows);
}

/** @param {number[]} values */
function median(values) {
  const ordered = [...values].sort((a, b) => a - b), middle = (ordered.length - 1) / 2;
  return (ordered[Math.floor(middle)] + ordered[Math.ceil(middle)]) / 2;
}

/** @param {Rounds} rounds @param {Runs | null} yours */
function described(rounds, yours) {
  const frame = `How far off the demonstrator the arm ended, from ${rounds.starts} starts`;
  return yours ? `${frame}: within ${rounds.withinDeg}° your choice from ${there(rounds, yours)}, the page's from ${
    there(rounds, rounds.runs[rounds.page])}.` : `${frame}: not run yet.`;
}
