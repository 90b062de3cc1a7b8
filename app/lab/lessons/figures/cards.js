/** Cards and tables as HTML, for figures that are words and numbers. */
import {told} from "../../view/words.js";
import {escaped} from "./drawing.js";

const ICONS = {
  learner: '<svg viewBox="0 0 16 16" aria-hidden="true"><circle cx="8" cy="8" r="6"/></svg>',
  truth: '<svg viewBox="0 0 16 16" aria-hidden="true"><path d="M8 1l7 7-7 7-7-7z"/></svg>',
};

/** Name a box of words and numbers. @param {HTMLElement} box @param {string} kind its class @param {string} name */
export function named(box, kind, name) {
  box.classList.add("bare", kind);
  box.setAttribute("role", "group");
  box.setAttribute("aria-label", name);
}

/** A figure of words and numbers in a named box, written again where they differ.
 * @param {string} kind class of the box @param {string} name
 * @param {(stage: import("../stage.js").Stage, layers: Set<string>) => string} write HTML
 * @returns {import("../stage.js").FigureKind["create"]} */
export const written = (kind, name, write) => box => {
  named(box, kind, name);
  let last = "";
  return {
    draw(stage, layers) {
      const html = write(stage, layers);
      if (html !== last) box.innerHTML = last = html;
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
 * @param {import("../stage.js").Claim} claim @param {{E: number[]}} run @param {string[]} names of the joints */
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
