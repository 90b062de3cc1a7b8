// What a tab keeps of its session: a query, which the server sends and gets back after a reload or a lost connection. It is
// in the tab's storage, and in its address while it is short.
"use strict";
const MAX_ADDRESS = 1500;  // characters of a session in the address

class TabSession {
  /** @param {() => Storage} storage  of the tab; it may throw @param {string} key  in the storage
   * @param {string} asked  the query that the address held when the page was opened */
  constructor(storage, key, asked) {
    this.storage = storage;
    this.key = key;
    this.text = "";  // what the server is handed back; "" for a new tab
    this.acted = 0;  // the last action that it includes
    this.problem = "";  // "storage" where the browser's is full or forbidden: the server has the words
    try {
      this.text = storage().getItem(key) ?? "";
    } catch {
      // storage is forbidden, which `store` says once there is something to store
    }
    // What the tab wrote into its address itself is no link that somebody has sent
    this.link = asked && asked !== this.text ? asked : "";
  }

  /** What belongs into the address: "" if it is too long. */
  get address() {
    return this.text.length <= MAX_ADDRESS ? this.text : "";
  }

  /** @param {string} json  {text, acted} */
  take(json) {
    const {text, acted} = JSON.parse(json);
    this.acted = acted;
    if (text === this.text) return;
    this.text = text;
    try {
      this.storage().setItem(this.key, text);
      this.problem = "";
    } catch {
      this.problem = this.address ? "" : "storage";
    }
  }
}
