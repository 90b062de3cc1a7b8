/** The connection of a class: one websocket that comes back, and answers that wait until the server has kept them. */

import {Memory} from "../view/memory.js";

/** @typedef {{kind: string, [field: string]: any}} Message
 * @typedef {{kind: "answer", seq: number, lesson: string, step: string, answer: Record<string, any>, round: number,
 * phase: string, sure: boolean | null, seconds: number | null}} Answer */
const FIRST_WAIT_MS = 400, LONGEST_WAIT_MS = 5000; // before the next try to connect
const RESEND_MS = 60; // between two answers that are sent again
const CAUSE_MS = 10_000; // without a connection, after which the page says why
const BLOCKED = `The server answers, but its websocket does not open. Try another network, or switch off filters and extensions. Lecturer: the server has to be begun with --address ${location.origin}${location.pathname} if students use a name or a proxy, which must pass on Upgrade and Connection.`;
const SILENT = "The server does not answer. Check that this device is on the class’s network, and that the server runs.";
const MAX_KEPT = 300, SEQUENCE = 1_000_000;
const PREFIX = `viewimit-class ${location.pathname} `;

/** For all tabs of the page, and for this one. */
export const browser = new Memory(() => localStorage, PREFIX);
export const tab = new Memory(() => sessionStorage, PREFIX);

/** Who this browser is to the class: a random number that nobody else has. */
function token() {
  let found = browser.get("token");
  if (!found || !/^[0-9a-f]{32}$/.test(found)) {
    found = [...crypto.getRandomValues(new Uint8Array(16))].map(byte => byte.toString(16).padStart(2, "0")).join("");
    browser.set("token", found);
  }
  return found;
}

export class Link {
  /** @param {(message: Message) => void} heard @param {() => void} changed the connection, or what waits */
  constructor(heard, changed) {
    this.heard = heard;
    this.changed = changed;
    this.isOpen = false;
    this.wait = FIRST_WAIT_MS;
    this.socket = /** @type {WebSocket | null} */ (null);
    this.lostAt = performance.now(); // when the connection was lost, or first tried
    this.cause = ""; // what keeps it from opening
    addEventListener("online", () => this.#connect());
    document.addEventListener("visibilitychange", () => { if (!document.hidden) this.#connect(); });
  }

  open() { this.#connect(); }

  #connect() {
    if (this.socket && this.socket.readyState <= WebSocket.OPEN) return;
    const address = new URL("socket", location.href.replace(/[?#].*/, ""));
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    const socket = this.socket = new WebSocket(address);
    socket.addEventListener("open", () => {
      const name = browser.get("name") ?? "", session = tab.get("session");
      const linked = browser.get("unlinked") !== "yes";
      socket.send(JSON.stringify({kind: "hello", token: token(), name, linked, ...session ? {session} : {}}));
    });
    socket.addEventListener("message", ({data}) => this.#hear(JSON.parse(data)));
    socket.addEventListener("close", () => {
      if (socket !== this.socket) return;
      if (this.isOpen) this.lostAt = performance.now();
      this.isOpen = false;
      this.#findCause();
      this.changed();
      setTimeout(() => this.#connect(), this.wait * (.5 + Math.random()));
      this.wait = Math.min(LONGEST_WAIT_MS, 1.7 * this.wait);
    });
  }

  /** Once it has been away for a while: whether the server answers, and so what is between. */
  async #findCause() {
    if (performance.now() - this.lostAt < CAUSE_MS) return;
    let answers = false;
    try { answers = (await fetch(location.href.replace(/#.*/, ""), {method: "HEAD", cache: "no-store"})).ok; } catch { /* it does not */ }
    if (this.isOpen) return;
    this.cause = answers ? BLOCKED : SILENT;
    this.changed();
  }

  /** @param {Message} message */
  #hear(message) {
    if (message.kind === "welcome") {
      this.isOpen = true;
      this.cause = "";
      this.wait = FIRST_WAIT_MS;
      this.changed();
      this.#resend();
    } else if (message.kind === "ack" || message.kind === "refused") this.#drop(message.seq);
    this.heard(message);
  }

  /** What may be lost: the next one says it again. @param {Message} message */
  send(message) {
    if (this.isOpen && this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** What must arrive. An answer replaces an earlier one to the same question. @param {Omit<Answer, "kind" | "seq">} given */
  answer(given) {
    const seq = Math.floor(SEQUENCE * Math.random()), answer = /** @type {Answer} */ ({kind: "answer", seq, ...given});
    const same = (/** @type {Answer} */ one) => one.lesson === given.lesson && one.step === given.step
      && one.round === given.round && one.phase === given.phase;
    this.#keep([...this.waiting().filter(one => !same(one)), answer]);
    this.send(answer);
  }

  /** Answers that the server has not yet kept. @returns {Answer[]} */
  waiting() {
    const found = browser.read("answers");
    return Array.isArray(found) ? found : [];
  }

  #resend() {
    const socket = this.socket;
    this.waiting().forEach((answer, k) => setTimeout(() => { if (socket === this.socket) this.send(answer); }, k * RESEND_MS));
  }

  /** @param {number} seq */
  #drop(seq) { this.#keep(this.waiting().filter(one => one.seq !== seq)); }

  /** @param {Answer[]} answers */
  #keep(answers) {
    browser.set("answers", answers.length ? JSON.stringify(answers.slice(-MAX_KEPT)) : null);
    this.changed();
  }
}
