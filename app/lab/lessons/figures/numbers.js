/** Figures that are numbers: E with its formula, how E went, who came how far, and what the crossing is near to.
 * @import {Stage, FigureKind, Race} from "../stage.js" */
import {farthest} from "../../engine/engine.js";
import {energyText, escaped, fixed} from "../../view/svg.js";
import {verdicts} from "../../view/words.js";
import {measure} from "../measures.js";
import {make} from "../dom.js";
import {written} from "./cards.js";
import {Chart, charted, stepTicks} from "./chart.js";

const MIN_E = 1e-3, MIN_STEPS = 6; // px², steps: of the axes at least
const FILLED = .85; // of the width, by squares: the rest is for numbers that are wider than theirs
const FEW = 30; // steps, of which test moves are hollow

/** @param {string} kind @param {number} aspect @param {(stage: Stage) => [string, string]} write @returns {FigureKind} */
const words = (kind, aspect, write) => ({layers: [], aspect, create: written(kind, write, true)});

/** E, and how near the crossing is to the learner's own point and to the ghost's. */
export const counts = words("draw-counts", 2.6, stage => {
  const of = (/** @type {string} */ name) => stage.isRevealed ? measure(stage, name).text : "?";
  const rows = [["Conflict E", of("E"), "draw-name-E"],
    ["Crossing to the ghost", of("crossing to ghost"), ""], ["Crossing to own point", of("crossing to own point"), ""]];
  const html = rows.map(([name, value, kind]) =>
    `<div><dt>${escaped(name)}</dt><dd class="${kind}">${escaped(value)}</dd></div>`).join("");
  return [`<dl>${html}</dl>`, rows.map(([name, value]) => `${name}: ${value}`).join(". ")];
});

/** E as the mean of the squared arrows, each of them a square of that area. */
export const formula = words("draw-formula", 1.3, stage => {
  const {moment} = stage, found = stage.recovered(), count = moment.usable.length;
  if (!moment.fitted) return ["<p>Too few points are seen.</p>", "Too few points are seen."];
  const squares = [0, 2].map(k => moment.usable.map(i => {
    const [u, v] = [k, k + 1].map(at => moment.views.own[4 * i + at] - found[4 * i + at]);
    return {i, area: u * u + v * v};
  }));
  const sums = squares.map(all => all.reduce((sum, {area}) => sum + area, 0));
  const largest = Math.sqrt(Math.max(...squares.flat().map(({area}) => area)));
  const total = Math.max(...squares.map(all => all.reduce((sum, {area}) => sum + Math.sqrt(area), 0))) || 1;
  const row = (/** @type {typeof squares[0]} */ all, /** @type {string} */ name, /** @type {number} */ sum) =>
    `<div class="draw-squares"><b class="vi-name">${name}</b>
<div style="max-width:calc(21cqh / ${fixed(Math.max(largest / total, .01), 3)})">${all.map(({i, area}) => {
    const share = 100 * Math.sqrt(area) / total, isLongest = Math.sqrt(area) === largest;
    const kind = isLongest && stage.isRevealed ? "longest" : "";
    return `<span class="${kind}"><i style="width:${fixed(FILLED * share, 2)}cqw"></i><small>${i + 1}</small></span>`;
  }).join("")}</div><p>together <b>${escaped(energyText(sum))} px²</b></p></div>`;
  const E = (sums[0] + sums[1]) / (2 * count);
  const html = `<p class="draw-note">Each arrow squared is the area of a square. The number under it is its point.</p>
${row(squares[0], "L", sums[0])}${row(squares[1], "R", sums[1])}
<p class="draw-sum"><span>E = </span><span class="draw-ratio">
<span>${escaped(sums.map(energyText).join(" + "))}</span><span>2 · ${count} points</span></span>
<span> = <b class="draw-name-E">${escaped(energyText(E))} px²</b></span></p>`;
  return [html, `E is ${energyText(sums[0])} plus ${energyText(sums[1])}, divided by two times ${count} points: ` +
    `${energyText(E)} px².`];
});

/** E as one large number, how it went step by step, and the goal. @type {FigureKind} */
export const progress = {
  layers: [],
  aspect: 1,
  create: box => {
    const words = make("div", {class: "draw-words"}), below = make("div", {class: "draw-progress-curve"});
    box.append(make("div", {class: "draw-progress"}, make("div", {class: "draw-inside"}, words, below)));
    const chart = new Chart(below);
    let last = "";
    return {
      resize: () => chart.resize(),
      draw: stage => {
        const {motions, goal, steps, isShown} = stage, E = motions.map(motion => Math.max(motion.E, MIN_E));
        const now = stage.moment.E;
        const change = steps && !isShown ? (E[steps] - E[steps - 1]) / E[steps - 1] : NaN;
        const share = `${change < 0 ? "▼" : "▲"} ${Math.round(100 * Math.abs(change))}`;
        const html = `<p class="draw-big draw-name-E">E ${escaped(energyText(now))}<small> px²</small></p>
<p class="draw-note">${Number.isFinite(change) ? `${share} % by your last step` : isShown ? "shown, not reached by you" : "&nbsp;"}</p>
<p class="draw-steps"><b>${steps}</b> ${steps === 1 ? "step" : "steps"}</p>`;
        if (html !== last) words.innerHTML = last = html;
        const least = Math.min(...E, goal ?? Infinity), most = Math.max(...E, goal ?? 0);
        const end = Math.max(MIN_STEPS, E.length - 1);
        chart.draw({
          x: [0, end], y: [least / 1.6, most * 1.6], log: true, xTicks: stepTicks(end), xName: "steps",
          levels: goal === null ? [] : [[goal, `goal ${goal} px²`, "goal"]],
        }, [{points: E.map((value, k) => [k, value]), role: "E"}],
          `E is ${energyText(now)} px² after ${steps} steps; the goal is ${goal ?? "not given"}.`);
      },
    };
  },
};

/** A race's cells: steps to the goal, E and how far off there, and why it ended.
 * @param {Stage} stage @param {Race} race */
function raceRow(stage, race) {
  if (!stage.isRevealed) return ["?", "", "", ""];
  const {E, postures, claim} = race, last = stage.last(race), {goal} = stage;
  const shown = stage.played(Math.max(...Object.values(stage.races).map(one => one.E.length)));
  if (shown < last) return ["…", energyText(E[shown]), "", ""];
  const off = farthest(postures[last], stage.moment.thetaDemo);
  const isThere = goal !== null && E[last] < goal;
  return [isThere ? String(last) : "never", energyText(E[last]), `${fixed(off)}°`,
    isThere ? "" : verdicts[claim.status].label];
}

/** Who came how far from the same start, the visitor first. */
export const standings = words("draw-standings", 2.2, stage => {
  const {goal, motions, steps} = stage, heads = ["", goal === null ? "steps" : `steps to ${goal}\u00a0px²`, "E", "off", ""];
  const rows = stage.racing.map(({role, title, race}) => [role, title, ...raceRow(stage, race)]);
  if (steps) {
    const {E, theta} = motions[steps], isThere = goal !== null && E < goal;
    const off = farthest(theta, stage.moment.thetaDemo);
    rows.unshift(["you", "you", isThere ? String(steps) : "never", energyText(E), `${fixed(off)}°`, ""]);
  }
  const sample = (/** @type {string} */ role) =>
    `<svg class="vi" viewBox="0 0 26 10" aria-hidden="true"><path class="draw-curve draw-of-${role}" d="M1 5h24"/>` +
      `</svg>`;
  const body = rows.map(([role, title, ...cells]) => `<tr><th scope="row">${sample(role)}${escaped(title)}</th>`
    + `${cells.map(cell => `<td>${escaped(cell)}</td>`).join("")}</tr>`).join("");
  const head = heads.map(words => words ? `<th scope="col">${escaped(words)}</th>` : "<td></td>").join("");
  return [`<table><thead><tr>${head}</tr></thead><tbody>${body}</tbody></table>`,
    `Steps to the goal from the same start. ${rows.map(([, title, steps]) => `${title}: ${steps}`).join("; ")}`];
});

/** How far off each prediction was. @type {FigureKind} */
export const predictions = {
  layers: [],
  title: "How far off your predictions were, px",
  aspect: 1.1,
  create: charted(({rounds}) => {
    const distance = (/** @type {number[]} */ p, /** @type {number[]} */ q) => Math.hypot(p[0] - q[0], p[1] - q[1]);
    const off = rounds.map(({mark, to}) => distance(mark, to)), count = Math.max(6, off.length);
    const last = rounds[off.length - 1];
    const share = last ? distance(last.mark, last.to) / distance(last.from, last.to) : Infinity;
    return [{
      x: [.4, count + .6], y: [0, 1.15 * Math.max(20, ...off)], xName: "turn",
      xTicks: Array.from({length: count}, (_, k) => [k + 1, String(k + 1)]),
      yName: share < 1 ? `the last: ${Math.round(100 * share)} % of the way` : "",
    }, off.map((value, k) =>
      ({points: [[k + 1, 0], [k + 1, value]], role: "bar", named: 1, name: String(Math.round(value))})),
    off.length ? `Your predictions were off by ${off.map(Math.round).join(", ")} px.` : "No prediction yet."];
  }),
};

/** E of both servos, step by step. @type {FigureKind} */
export const energies = {
  layers: ["curves"],
  title: "E after each step",
  aspect: 1.4,
  create: charted((stage, layers) => {
    const {goal} = stage, hasCurves = layers.has("curves"), races = stage.racing.map(({role, title, race}) =>
      ({role, title, last: stage.last(race), probes: race.probes, E: race.E.slice(0, stage.last(race) + 1)}));
    const all = races.flatMap(({E}) => E).filter(Number.isFinite);
    const end = Math.max(MIN_STEPS, ...races.map(({last}) => last));
    const shown = stage.played(end + 1);
    const curves = races.map(({role, title, last, probes, E}) => ({
      role, points: E.map((value, k) => [k, Math.max(value, MIN_E)]), shown: hasCurves ? shown + 1 : 1,
      hollow: last < FEW ? E.map((_, k) => Boolean(probes[k + 1])) : [],
      name: hasCurves ? `${title}${shown >= last ? `: ${last}` : ""}` : "",
    }));
    const least = Math.max(MIN_E, Math.min(...all, goal ?? Infinity));
    const words = hasCurves ? races.map(({title, last}) => `${title}: ${last} steps`).join("; ") : "E at the start";
    return [{
      x: [0, end], y: [least / 1.5, Math.max(...all) * 1.5], log: true, xTicks: stepTicks(end), xName: "steps",
      yName: "E, px²", levels: goal === null ? [] : [[goal, `goal ${goal}`, "goal"]],
    }, curves, words];
  }),
};
