/** Cards and tables as HTML, for figures that are words and numbers.
 * @import {Stage, FigureKind, Claim} from "../stage.js" */
import {told} from "../../view/words.js";
import {make} from "../dom.js";
import {escaped} from "../../view/svg.js";

const ICONS = {
  learner: '<svg viewBox="0 0 16 16" aria-hidden="true"><circle cx="8" cy="8" r="6"/></svg>',
  truth: '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M8 1l7 7-7 7-7-7z"/></svg>',
};

/** A figure of words and numbers in a named box, written again where they differ.
 * @param {string} kind class of the box
 * @param {(stage: Stage, layers: Set<string>) => [string, string]} write HTML, and what a screen reader says
 * @param {boolean} [isFramed] whether it stands in the frame of a drawing @returns {FigureKind["create"]} */
export const written = (kind, write, isFramed = false) => box => {
  const made = isFramed ? box.appendChild(make("div", {class: kind})) : box;
  if (!isFramed) box.classList.add("bare", kind);
  made.setAttribute("role", "group");
  let last = "";
  return {
    draw(stage, layers) {
      const [html, label] = write(stage, layers);
      if (html !== last) made.innerHTML = last = html;
      made.setAttribute("aria-label", label);
    },
  };
};

/** A card with a small head.
 * @param {"learner" | "truth" | "plain"} kind @param {string} head
 * @param {string} bold its main sentence; empty for none @param {string} [more] HTML after it
 * @param {string} [dot] colour of the mark before the main sentence */
export function card(kind, head, bold, more = "", dot = "") {
  const icon = kind === "plain" ? "" : ICONS[kind], mark = dot ? `<i class="state ${dot}"></i>` : "";
  const said = bold ? `<b>${mark}${escaped(bold)}</b>` : "";
  return `<div class="lesson-says lesson-says-${kind}"><small>${icon}${escaped(head)}</small>${said}${more}</div>`;
}

/** How a run ended, as every front end says it.
 * @param {Claim} claim @param {{E: number[]}} run @param {string[]} names of the joints */
export const ending = ({status, seen, unobservable, expectedOffDeg}, {E}, names) => told(status, {
  steps: E.length - 1, E: E[E.length - 1], seen, expectedOffDeg,
  joints: unobservable.length ? `the ${unobservable.map(k => names[k]).join(" and the ")}` : undefined,
});

/** @param {string[]} heads @param {string[][]} rows words, escaped here; the first cell of a row is its name */
export function table(heads, rows) {
  const cells = (/** @type {string[]} */ of, /** @type {string} */ tag) =>
    `<tr>${of.map(each => `<${tag}>${escaped(each)}</${tag}>`).join("")}</tr>`;
  const body = rows.map(row => cells(row, "td")).join("");
  return `<table><thead>${cells(heads, "th")}</thead><tbody>${body}</tbody></table>`;
}
