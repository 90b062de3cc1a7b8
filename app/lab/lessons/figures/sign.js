/** A finished run and its claim: the learner's knowledge, the truth, and how bets on it have done beside the learner's
 * own certificate.
 * @import {Stage, FigureKind, Claim} from "../stage.js" @import {Outline} from "../../view/images.js"
 * @typedef {Object} Run as the library records it
 * @property {string} name of its difference
 * @property {Claim} claim
 * @property {number[][]} postures rad
 * @property {number[]} E px²
 * @property {boolean[]} probes
 * @property {string} method servo and transfer
 * @property {string} points how many are seen, and on which links
 * @property {string} noise
 * @property {number[]} offDeg of each joint at the end
 * @property {boolean} holds whether the claim is true
 * @property {number | null} certificate the probability that the learner gives its claim; null if it gives none
 * @property {string} because one sentence on the claim
 * @property {number[]} own (4 N) px of the seen points at the end
 * @property {number[]} recovered (4 N) px */
import {Outlines} from "../../view/images.js";
import {energyText, escaped, fixed, px} from "../../view/svg.js";
import {make} from "../dom.js";
import {card, ending, table, written} from "./cards.js";
import {Chart, stepTicks} from "./chart.js";
import {axis, diamonds, dots, Drawing, fitted, path, polyline, rectangle, sketched, text} from "./drawing.js";

const NO_IDEA = .5; // what a bet is where nothing is claimed
const LEAST_E = 1e-4, MARGIN = 16, GAP = 10;

/** @type {FigureKind} */
export const CLAIM = {
  layers: ["learner knows", "truth"],
  title: "",
  aspect: 1.2,
  create: written("lesson-claim", (stage, layers) => [claimed(stage, layers), "The claim of a run, and the facts about it"]),
};

/** @type {FigureKind} */
export const RUN_IMAGES = {
  layers: [],
  title: "**L** and **R** at the end",
  aspect: 1.7,
  create: sketched("lesson-run-images", (drawing, stage) => {
    const {page, world} = stage, run = runOf(stage), end = run.postures[run.postures.length - 1];
    const arm = new Outlines(page.hulls).of(world, "learner", end, "end");
    return [[0, 1].map(side => image(drawing, run, arm[side], side)).join(""),
      `Pictures L and R: the learner's own arm at the end, with ${run.own.length / 4} points.`];
  }),
};

/** @type {FigureKind} */
export const E_HISTORY = {
  layers: [],
  title: "E after each step, px²",
  aspect: 1.9,
  create: box => {
    const chart = new Chart(box);
    return {
      resize: () => chart.resize(),
      draw(stage) {
        const {E, probes} = runOf(stage), last = E.length - 1, points = E.map((v, k) => [k, Math.max(v, LEAST_E)]);
        const all = points.map(([, v]) => v);
        box.classList.toggle("lesson-gone", isOver(stage)); // all runs are listed then
        chart.draw({x: [0, Math.max(last, 1)], y: [Math.min(...all) / 1.5, 1.5 * Math.max(...all)], log: true,
          xTicks: stepTicks(last), xName: "step"}, [{points, role: "E", hollow: probes}],
        `E after each of ${last} steps: from ${words(E[0])} to ${words(E[last])} px².`);
      },
    };
  },
};

/** @type {FigureKind} */
export const BETS = {
  layers: [],
  title: "What each bet cost",
  aspect: 2.2,
  create(box) {
    box.classList.add("bare", "lesson-bets");
    const said = make("p"), plain = make("div", {class: "lesson-plain"});
    box.append(said, plain);
    const drawing = new Drawing(plain, "");
    return {
      resize: () => drawing.measure(),
      draw(stage) {
        const {costs, count, yours, certificate} = scores(stage);
        said.innerHTML = !count ? "Each bet costs (bet − outcome)². Always 50 % costs 0.25."
          : `<b>Your Brier score so far: ${fixed(yours, 2)}.</b> The learner’s own certificate: ${
            fixed(certificate, 2)}. Always 50 %: 0.25. Less is better.`;
        const each = costs.map((cost, k) => cost === null ? "" : `Run ${k + 1} cost ${fixed(cost, 2)}. `);
        drawing.show(bars(drawing, stage), each.join("") || "No bet yet.");
      },
    };
  },
};

/** @type {FigureKind} */
export const REVIEW_OF_RUNS = {
  layers: [],
  title: "All runs",
  aspect: 1.6,
  create: written("lesson-table", stage => [isOver(stage) ? review(stage) : "", "All runs, your bets and the certificates"]),
};

/** @param {Stage} stage @returns {Run[]} */
const runsOf = stage => stage.records.runs;

/** The run that is shown. @param {Stage} stage */
export const runOf = stage => runsOf(stage)[stage.run];

/** %, by run; undefined or null without one. @param {Stage} stage @returns {(number | null | undefined)[]} */
function betsOf(stage) {
  const bets = [...stage.bets];
  if (stage.isRevealed && stage.answer.bet !== undefined) bets[stage.run] = stage.answer.bet;
  return bets;
}

/** Whether a bet was made on each run, and each has been shown. @param {Stage} stage */
export const isOver = stage => stage.isRevealed && stage.run === runsOf(stage).length - 1;

/** Mean squared differences between bets and outcomes. @param {Stage} stage */
export function scores(stage) {
  const runs = runsOf(stage), bets = betsOf(stage);
  const cost = (/** @type {number} */ bet, /** @type {boolean} */ holds) => (bet - Number(holds)) ** 2;
  const costs = runs.map(({holds}, k) => typeof bets[k] === "number" ? cost(Number(bets[k]) / 100, holds) : null);
  const known = costs.filter(each => each !== null);
  const judged = runs.filter((_, k) => costs[k] !== null);
  const own = judged.map(({holds, certificate}) => cost(certificate ?? NO_IDEA, holds));
  const mean = (/** @type {number[]} */ of) => of.reduce((sum, v) => sum + v, 0) / of.length;
  return {costs, count: known.length, yours: mean(known), certificate: mean(own)};
}

/** E in words. @param {number} E */
const words = E => E < LEAST_E ? "< 0.0001" : E < .1 ? String(Number(E.toPrecision(2))) : energyText(E);

/** @param {Stage} stage @param {Set<string>} layers */
function claimed(stage, layers) {
  const run = runOf(stage), names = stage.world.scene.names.map(name => name.split(" ")[0].toLowerCase());
  const rows = [
    ["E", `${words(run.E[run.E.length - 1])} px²`], ["Steps made", String(run.E.length - 1)],
    ["Method", run.method], ["Points seen", run.points], ["Noise in the pictures", run.noise],
  ].map(([name, value]) => `<tr><th>${name}</th><td class="lesson-of-${name[0]}">${escaped(value)}</td></tr>`);
  const ended = ending(run.claim, run, names), table = `<p>${escaped(ended.says)}</p><table>${rows.join("")}</table>`;
  const known = card("plain", "How it ended, as the learner knows it", ended.label, table, ended.dot);
  const off = run.offDeg.map((v, k) => `${fixed(v)}° off at the ${names[k]}`).join(", ");
  const outcome = `${run.holds ? "True" : "False"}: ${off}.`, because = `<p>${escaped(run.because)}</p>`;
  const truth = card("truth", "The truth (hidden from the learner)", outcome, because);
  const head = `Run ${stage.run + 1} of ${runsOf(stage).length}: the claim`;
  const claim = card("learner", head, "“Both joints are within 1° of the demonstrator’s.”");
  const isTrueShown = layers.has("truth") && !stage.truthHidden;
  return claim + (isTrueShown ? truth : "") + (layers.has("learner knows") && !isOver(stage) ? known : "");
}

/** One of both images at the end.
 * @param {Drawing} drawing @param {Run} run @param {Outline} arm @param {number} side */
function image({width, height}, {own, recovered}, {hulls, bones}, side) {
  const wide = (width - GAP) / 2, left = side * (wide + GAP);
  const {place} = fitted([...hulls.flat(), ...bones], [left + MARGIN, MARGIN, left + wide - MARGIN, height - MARGIN]);
  const points = (/** @type {number[]} */ of) =>
    Array.from({length: of.length / 4}, (_, i) => place([of[4 * i + 2 * side], of[4 * i + 2 * side + 1]]));
  const outline = hulls.map(hull => `${polyline(hull.map(place))}z`).join("");
  return rectangle("vi-plane", left + .5, .5, wide - 1, height - 1, 5) + path("vi-hull", outline)
    + path("vi-bone", polyline(bones.map(place))) + path("vi-own", dots(points(own)))
    + path("vi-found", diamonds(points(recovered), 5)) + text(left + 8, 19, "LR"[side], "vi-name vi-halo");
}

/** The cost of each bet. @param {Drawing} drawing @param {Stage} stage */
function bars({width, height}, stage) {
  const {costs, count} = scores(stage), each = width / costs.length, bottom = height - 20;
  const y = axis(0, 1, bottom, 16), wide = Math.min(30, each * .62), quarter = NO_IDEA ** 2;
  let svg = path("vi-rule", `M0 ${px(bottom)}H${px(width)}`) + path("lesson-goal", `M0 ${px(y(quarter))}H${px(width)}`);
  if (!count) svg += text(width - 2, y(quarter) - 5, `50 % costs ${quarter}`, "vi-2nd vi-end");
  costs.forEach((cost, k) => {
    const middle = each * (k + .5), top = Math.min(y(cost ?? 0), bottom - 1.5);
    svg += text(middle, bottom + 15, String(k + 1), k === stage.run ? "vi-b vi-mid" : "vi-2nd vi-mid");
    if (cost === null) return;
    svg += rectangle("lesson-bet", middle - wide / 2, top, wide, bottom - top, 2);
    const label = Math.abs(top - 8 - y(quarter)) < 9 ? y(quarter) - 4 : top - 4; // not on the dashed line
    if (each > 27) svg += text(middle, label, fixed(cost, 2), "vi-2nd vi-mid vi-halo");
  });
  return svg;
}

/** @param {Stage} stage */
function review(stage) {
  const bets = betsOf(stage);
  return table(["run", "E, px²", "truly off", "within 1°?", "you", "its certificate"],
    runsOf(stage).map(({name, E, offDeg, holds, certificate}, k) => [
      `${k + 1}. ${name}`, words(E[E.length - 1]), `${fixed(Math.max(...offDeg))}°`, holds ? "true" : "false",
      typeof bets[k] === "number" ? `${bets[k]} %` : "–",
      certificate === null ? "no claim" : `${Math.round(100 * certificate)} %`,
    ]));
}
