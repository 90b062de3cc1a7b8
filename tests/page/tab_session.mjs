// What a tab keeps, without a browser: node tab_session.mjs session.js
import assert from "node:assert/strict";
import {readFileSync} from "node:fs";

const TabSession = new Function(`${readFileSync(process.argv[2], "utf8")}; return TabSession;`)();
const memory = (kept = {}) => ({getItem: key => kept[key] ?? null, setItem: (key, value) => { kept[key] = value; }});
const forbidden = () => { throw new Error("SecurityError"); };
const full = {getItem: () => null, setItem: () => { throw new Error("QuotaExceededError"); }};
const sent = (text, acted = 0) => JSON.stringify({text, acted});

const cases = {
  "what was stored is there after a reload, and its own address is no link"() {
    const kept = {}, tab = new TabSession(() => memory(kept), "k", "");
    assert.equal(tab.text, "");
    tab.take(sent("preset=paper&steps=3", 7));
    assert.deepEqual([tab.text, tab.acted, tab.address], ["preset=paper&steps=3", 7, "preset=paper&steps=3"]);
    const again = new TabSession(() => memory(kept), "k", "preset=paper&steps=3");
    assert.deepEqual([again.text, again.link], ["preset=paper&steps=3", ""]);
    assert.equal(new TabSession(() => memory(kept), "k", "preset=noise").link, "preset=noise");
    assert.equal(new TabSession(() => memory(kept), "other", "").text, "");
  },
  "a long session is not in the address"() {
    const tab = new TabSession(() => memory(), "k", "");
    tab.take(sent("x".repeat(2000)));
    assert.deepEqual([tab.address, tab.problem], ["", ""]);
  },
  "where nothing can be stored a short session is in the address, and of a long one it is said"() {
    for (const storage of [forbidden, () => full]) {
      const tab = new TabSession(storage, "k", "steps=2");
      assert.equal(tab.link, "steps=2");
      tab.take(sent("steps=3"));
      assert.deepEqual([tab.address, tab.problem], ["steps=3", ""]);
      tab.take(sent("x".repeat(2000)));
      assert.equal(tab.problem, "storage");
    }
  },
};

for (const [name, run] of Object.entries(cases)) {
  run();
  console.log(`ok: ${name}`);
}
