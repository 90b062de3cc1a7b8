// What a tab keeps of its session: the blocks of a text that the server sends in parts and gets back after a reload or a
// lost connection. They are in the tab's storage, and in its address while they are short.
"use strict";
const MAX_ADDRESS = 1500;  // characters of a session in the address

class TabSession {
  /**
   * @param {() => Storage} storage  of the tab; it may throw
   * @param {string} key  in the storage
   * @param {string | null} asked  the session that the address held when the page was opened
   */
  constructor(storage, key, asked) {
    this.storage = storage;
    this.key = key;
    /** @type {string[]} */
    this.blocks = [];
    this.address = "";
    this.number = 0;  // of the last part on this connection
    this.acted = 0;  // the last action that the blocks include
    this.problem = "";  // "storage" where the browser's is full or forbidden: the server has the words
    try {
      const kept = JSON.parse(storage().getItem(key) ?? "{}");
      if (Array.isArray(kept.blocks)) this.blocks = kept.blocks.map(String);
      if (typeof kept.address === "string") this.address = kept.address;
    } catch {
      this.blocks = [];  // of another page, or storage is forbidden: which `store` says, once there is something to store
    }
    // What the tab wrote into its address itself is no link that somebody has sent
    this.link = asked && asked !== this.address && asked !== this.text ? asked : "";
  }

  /** What the server is handed back; "" for a new tab. */
  get text() {
    return this.blocks.join(".");
  }

  /** What belongs into the address: "" if it is too long. */
  get short() {
    return this.text.length <= MAX_ADDRESS ? this.text : "";
  }

  /** Begin on a new connection, whose parts are counted from 1. */
  connect() {
    this.number = 0;
  }

  /**
   * Take a part.
   * @param {string} json  {number, at, blocks, acted}
   * @returns {boolean} false if one before it is missing
   */
  take(json) {
    const part = JSON.parse(json);
    const follows = part.at === 0 || (part.number === this.number + 1 && part.at <= this.blocks.length);
    if (!follows) return false;
    this.number = part.number;
    this.acted = part.acted;
    if (part.at < 0) return true;  // nothing but actions that change nothing of it
    this.blocks = [...this.blocks.slice(0, part.at), ...part.blocks];
    this.address = this.short;
    this.store();
    return true;
  }

  store() {
    try {
      this.storage().setItem(this.key, JSON.stringify({blocks: this.blocks, address: this.address}));
      this.problem = "";
    } catch {
      this.problem = this.short ? "" : "storage";
    }
  }
}
