/**
 * A finished run and its claim: what the learner knows, what is true, and how bets on it have done beside the learner's
 * own certificate.
 *
 * @typedef {import("../stage.js").Stage} Stage
 * @typedef {import("../stage.js").FigureKind} FigureKind
 * @typedef {Object} Run as the library records it
 * @property {string} name what was different about it
 * @property {string} ended in words
 * @property {number[][]} postures rad
 * @property {number[]} E px²
 * @property {boolean[]} probes
 * @property {string} points how many are seen, and on which links
 * @property {string} noise
 * @property {number[]} offDeg of each joint at the end
 * @property {boolean} holds whether the claim is true
 * @property {number | null} certificate the probability that the learner gives its claim; null if it gives none
 * @property {number[]} own (4 N) px of the seen points at the end
 * @property {number[]} recovered (4 N) px
 */
import {Outlines} from "../../view/images.js";
import {energyText, fixed, px} from "../../view/svg.js";
import {axis, diamonds, dots, Drawing, escaped, path, polyline, text, widthOf} from "./drawing.js";

const NO_IDEA = .5; // what a bet is where nothing is claimed
const LEAST_E = 1e-4, MARGIN = 16, GAP = 10;

/** @type {FigureKind} */
export const CLAIM = {
  layers: ["learner knows", "truth"],
  title: "",
  aspect: 1.2,
  create(box) {
    box.classList.add("lesson-claim");
    let last = "";
    return {
      draw(stage, layers) {
        const html = claimed(stage, layers);
        if (html !== last) box.innerHTML = last = html;
      },
    };
  },
};

/** @type {FigureKind} */
export const RUN_IMAGES = {
  layers: [],
  title: "**L** and **R** at the end",
  aspect: 1.7,
  create(box, stage) {
    const drawing = new Drawing(box, "lesson-run-images"), outlines = new Outlines(stage.page.hulls);
    return {
      resize: () => drawing.measure(),
      draw(now) {
        const run = runOf(now), arm = outlines.of(now.world, "learner", run.postures[run.postures.length - 1], "own");
        drawing.show([0, 1].map(side => image(drawing, run, arm[side], side)).join(""),
          `Images L and R: the learner's own arm at the end, with ${run.own.length / 4} points.`);
      },
    };
  },
};

/** @type {FigureKind} */
export const E_HISTORY = {
  layers: [],
  title: "E after each step, px²",
  aspect: 1.9,
  create(box) {
    const drawing = new Drawing(box, "lesson-history");
    return {
      resize: () => drawing.measure(),
      draw(stage) {
        const {E, probes} = runOf(stage);
        drawing.show(history(drawing, E, probes), `E after each of ${E.length - 1} steps: from ${words(E[0])} to ${words(E[E.length - 1])} px².`);
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
    box.classList.add("lesson-bets");
    const said = document.createElement("p"), plain = document.createElement("div");
    plain.className = "lesson-plain";
    box.append(said, plain);
    const drawing = new Drawing(plain, "");
    return {
      resize: () => drawing.measure(),
      draw(stage) {
        const score = scores(stage);
        said.innerHTML = score.count ? `<b>Your Brier score so far: ${fixed(score.yours, 2)}.</b> The learner's own certificate: ${
          fixed(score.certificate, 2)}. Always 50 %: 0.25. Less is better.` : "Each bet costs (bet − outcome)². Always 50 % costs 0.25.";
        drawing.show(bars(drawing, stage), score.costs.map((cost, k) => cost === null ? "" : `Run ${k + 1} cost ${fixed(cost, 2)}. `).join("") || "No bet yet.");
      },
    };
  },
};

/** @type {FigureKind} */
export const REVIEW_OF_RUNS = {
  layers: [],
  title: "All runs",
  aspect: 1.6,
  create(box) {
    box.classList.add("lesson-table");
    return {
      draw(stage) {
        box.innerHTML = isOver(stage) ? review(stage) : "";
      },
    };
  },
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
  const costs = runs.map(({holds}, k) => typeof bets[k] === "number" ? (Number(bets[k]) / 100 - Number(holds)) ** 2 : null);
  const own = runs.map(({holds, certificate}) => ((certificate ?? NO_IDEA) - Number(holds)) ** 2).filter((_, k) => costs[k] !== null);
  const known = costs.filter(cost => cost !== null), mean = (/** @type {number[]} */ of) => of.reduce((sum, v) => sum + v, 0) / of.length;
  return {costs, count: known.length, yours: mean(known), certificate: mean(own)};
}

/** E in words. @param {number} E */
const words = E => E < LEAST_E ? "< 0.0001" : E < .1 ? String(Number(E.toPrecision(2))) : energyText(E);

/** @param {Stage} stage @param {Set<string>} layers */
function claimed(stage, layers) {
  const run = runOf(stage), names = stage.world.scene.names.map(name => name.split(" ")[0].toLowerCase());
  const rows = [["How it ended", run.ended], ["E", `<b class="lesson-E">${words(run.E[run.E.length - 1])} px²</b>`],
    ["Steps made", String(run.E.length - 1)], ["Points seen", run.points], ["Noise in the pictures", run.noise]];
  const known = layers.has("learner knows") ? `<div class="lesson-says"><small>What the learner knows</small><table>${
    rows.map(([name, value]) => `<tr><th>${name}</th><td>${value}</td></tr>`).join("")}</table></div>` : "";
  const off = run.offDeg.map((v, k) => `${fixed(v)}° off at the ${names[k]}`).join(", ");
  const truth = layers.has("truth") && !stage.truthHidden ? `<div class="lesson-says lesson-says-truth"><small>The truth (hidden from the learner)</small><b>${
    run.holds ? "True" : "False"}: ${off}.</b></div>` : "";
  return `<div class="lesson-says lesson-says-learner"><small>Run ${stage.run + 1} of ${runsOf(stage).length}: the claim</small>
<b>“Both joints are within 1° of the demonstrator's.”</b></div>${known}${truth}`;
}

/** One of both images at the end. @param {Drawing} drawing @param {Run} run @param {import("../../view/images.js").Outline} arm @param {number} side */
function image({width, height}, {own, recovered}, {hulls, bones}, side) {
  const wide = (width - GAP) / 2, left = side * (wide + GAP), all = [...hulls.flat(), ...bones];
  const low = [0, 1].map(k => Math.min(...all.map(p => p[k]))), high = [0, 1].map(k => Math.max(...all.map(p => p[k])));
  const scale = Math.min((wide - 2 * MARGIN) / (high[0] - low[0]), (height - 2 * MARGIN) / (high[1] - low[1]));
  const place = (/** @type {number[]} */ p) => [left + wide / 2 + (p[0] - (low[0] + high[0]) / 2) * scale,
    height / 2 + (p[1] - (low[1] + high[1]) / 2) * scale];
  const points = (/** @type {number[]} */ of) =>
    Array.from({length: of.length / 4}, (_, i) => place([of[4 * i + 2 * side], of[4 * i + 2 * side + 1]]));
  return `<rect class="vi-plane" x="${px(left + .5)}" y=".5" width="${px(wide - 1)}" height="${px(height - 1)}" rx="5"/>
${path("vi-hull", hulls.map(hull => `${polyline(hull.map(place))}z`).join(""))}${path("vi-bone", polyline(bones.map(place)))}${
    path("vi-own", dots(points(own)))}${path("vi-found", diamonds(points(recovered), 5))}${
    text(left + 8, 19, "LR"[side], "vi-name vi-halo")}`;
}

/** On a logarithmic scale. @param {Drawing} drawing @param {number[]} all @param {boolean[]} probes */
function history({width, height}, all, probes) {
  const E = all.map(v => Math.max(v, LEAST_E)), from = 10 ** Math.floor(Math.log10(Math.min(...E))), to = 10 ** Math.ceil(Math.log10(Math.max(...E)));
  const left = 50, right = width - 12, top = 10, bottom = height - 34, y = axis(from, to, bottom, top, true), x = axis(0, Math.max(E.length - 1, 1), left, right);
  const count = Math.round(Math.log10(to / from)), every = Math.ceil(count / Math.max(2, (bottom - top) / 20));
  const ticks = Array.from({length: count + 1}, (_, k) => from * 10 ** k).filter((_, k) => k % every === 0);
  const steps = Math.ceil((E.length - 1) / Math.max(3, (right - left) / 34)) || 1, points = E.map((v, k) => [x(k), y(v)]);
  let svg = path("vi-rule", ticks.map(v => `M${left} ${px(y(v))}H${px(right)}`).join(""));
  svg += ticks.map(v => text(left - 6, y(v) + 4.5, v < 1 ? String(Number(v.toPrecision(1))) : v.toFixed(0), "vi-2nd vi-end")).join("");
  for (let k = 0; k < E.length; k += steps) svg += text(x(k), bottom + 16, String(k), "vi-2nd vi-mid");
  svg += text((left + right) / 2, bottom + 31, "step", "vi-2nd vi-mid") + path("vi-line-E", polyline(points));
  return svg + path("lesson-E-dots", dots(points.filter((_, k) => !probes[k])))
    + points.filter((_, k) => probes[k]).map(p => `<circle class="vi-probe-E" cx="${px(p[0])}" cy="${px(p[1])}" r="3.6"/>`).join("");
}

/** The cost of each bet. @param {Drawing} drawing @param {Stage} stage */
function bars({width, height}, stage) {
  const {costs} = scores(stage), each = width / costs.length, bottom = height - 20, y = axis(0, 1, bottom, 16), wide = Math.min(30, each * .62);
  const quarter = `costs ${fixed(NO_IDEA ** 2, 2)}`;
  let svg = path("vi-rule", `M0 ${px(bottom)}H${px(width)}`) + path("lesson-goal", `M0 ${px(y(.25))}H${px(width)}`);
  costs.forEach((cost, k) => {
    const middle = each * (k + .5), kind = k === stage.run ? "vi-b vi-mid" : "vi-2nd vi-mid";
    svg += text(middle, bottom + 15, String(k + 1), kind);
    if (cost === null) return;
    const top = Math.min(y(cost), bottom - 1.5);
    svg += `<rect class="lesson-bet" x="${px(middle - wide / 2)}" y="${px(top)}" width="${px(wide)}" height="${px(bottom - top)}" rx="2"/>`;
    if (each > 27) svg += text(middle, top - 4, fixed(cost, 2), "vi-2nd vi-mid vi-halo");
  });
  return costs.some(cost => cost !== null) ? svg : svg + text(width - widthOf(quarter) - 2, y(.25) - 5, quarter, "vi-2nd");
}

/** @param {Stage} stage */
function review(stage) {
  const bets = betsOf(stage), rows = runsOf(stage).map(({name, E, offDeg, holds, certificate}, k) => {
    const cells = [words(E[E.length - 1]), `${fixed(Math.max(...offDeg))}°`, holds ? "true" : "false",
      typeof bets[k] === "number" ? `${bets[k]} %` : "–", certificate === null ? "no claim" : `${Math.round(100 * certificate)} %`];
    return `<tr><td>${k + 1}. ${escaped(name)}</td>${cells.map(cell => `<td>${cell}</td>`).join("")}</tr>`;
  });
  const heads = ["run", "E, px²", "truly off", "within 1°?", "you", "its certificate"];
  return `<table><thead><tr>${heads.map(head => `<th>${head}</th>`).join("")}</tr></thead><tbody>${rows.join("")}</tbody></table>`;
}
