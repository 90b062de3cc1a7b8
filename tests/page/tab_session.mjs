// What a tab keeps, without a browser: node tab_session.mjs session.js
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";

const TabSession = new Function(`${readFileSync(process.argv[2], "utf8")}; return TabSession;`)();
const memory = (kept = {}) => ({getItem: key => kept[key] ?? null, setItem: (key, value) => { kept[key] = value; }});
const forbidden = () => { throw new Error("SecurityError"); };
const full = {getItem: () => null, setItem: () => { throw new Error("QuotaExceededError"); }};
const part = (number, at, blocks, acted = 0) => JSON.stringify({number, at, blocks, acted});

const cases = {
  "parts replace blocks from where they begin"() {
    const tab = new TabSession(() => memory(), "k", null);
    assert.equal(tab.text, "");
    assert.ok(tab.take(part(1, 0, ["2", "a", "h"])));
    assert.ok(tab.take(part(2, 2, ["b", "i"], 7)));
    assert.deepEqual([tab.text, tab.acted, tab.address], ["2.a.b.i", 7, "2.a.b.i"]);
    assert.ok(tab.take(part(3, -1, [], 9)));
    assert.deepEqual([tab.text, tab.acted], ["2.a.b.i", 9]);
  },
  "a part after one that is missing is not taken, and all again is"() {
    const tab = new TabSession(() => memory(), "k", null);
    tab.take(part(1, 0, ["2", "a", "h"]));
    assert.ok(!tab.take(part(3, 1, ["x"])));
    assert.ok(!tab.take(part(2, 9, ["x"])));
    assert.equal(tab.text, "2.a.h");
    assert.ok(tab.take(part(4, 0, ["2", "c"])));
    assert.equal(tab.text, "2.c");
  },
  "what was stored is there after a reload, and its own address is no link"() {
    const kept = {}, tab = new TabSession(() => memory(kept), "k", null);
    tab.take(part(1, 0, ["2", "a", "h"]));
    const again = new TabSession(() => memory(kept), "k", "2.a.h");
    assert.deepEqual([again.text, again.link], ["2.a.h", ""]);
    again.connect();
    assert.ok(again.take(part(1, 2, ["i"])), "parts are counted anew on each connection");
    assert.equal(new TabSession(() => memory(kept), "k", "2.a.h").link, "2.a.h", "an older one is");
    assert.equal(new TabSession(() => memory(kept), "k", "1other").link, "1other");
    assert.equal(new TabSession(() => memory(kept), "other", null).text, "");
  },
  "a long session is not in the address"() {
    const tab = new TabSession(() => memory(), "k", null);
    tab.take(part(1, 0, ["2", "x".repeat(2000)]));
    assert.equal(tab.address, "");
  },
  "where nothing can be stored a short session is in the address, and of a long one it is said"() {
    for (const storage of [forbidden, () => full]) {
      const tab = new TabSession(storage, "k", "2.a");
      assert.equal(tab.link, "2.a");
      tab.take(part(1, 0, ["2", "a", "h"]));
      assert.deepEqual([tab.address, tab.problem], ["2.a.h", ""]);
      tab.take(part(2, 1, ["x".repeat(2000)]));
      assert.equal(tab.problem, "storage");
    }
  },
  "what another page has left in the storage is none of its own"() {
    for (const left of ["nonsense", "[]", '{"blocks": 3}', '{"address": 1}'])
      assert.equal(new TabSession(() => memory({k: left}), "k", null).text, "");
  },
};
for (const [name, run] of Object.entries(cases)) {
  run();
  console.log(`ok: ${name}`);
}
