/** What a browser keeps for a page, in its own storage or in a tab's; else as long as the page is open. */
export class Memory {
  /** @param {() => Storage} storage @param {string} prefix of all keys */
  constructor(storage, prefix) {
    this.prefix = prefix;
    this.own = /** @type {Map<string, string>} */ (new Map());
    this.storage = /** @type {Storage | null} */ (null);
    try {
      storage().setItem(`${prefix}test`, "1");
      storage().removeItem(`${prefix}test`);
      this.storage = storage();
    } catch { /* a frame or a private window that keeps nothing */ }
  }

  /** @param {string} key */
  get(key) { return this.storage ? this.storage.getItem(this.prefix + key) : this.own.get(key) ?? null; }

  /** What was kept as JSON; null for nothing, or if it is none. @param {string} key @returns {any} */
  read(key) {
    try { return JSON.parse(this.get(key) ?? "null"); } catch { return null; }
  }

  /** @param {string} key @param {string | null} value null forgets it */
  set(key, value) {
    if (value === null) this.own.delete(key);
    else this.own.set(key, value);
    try {
      if (value === null) this.storage?.removeItem(this.prefix + key);
      else this.storage?.setItem(this.prefix + key, value);
    } catch { this.storage = null; }
  }
}
