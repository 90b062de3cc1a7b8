/** node elsewhere.mjs LAB: lessons and the lab's data on standard input; how each step's links open, on standard output. */
import path from "node:path";
import {pathToFileURL} from "node:url";

const from = name => import(pathToFileURL(path.join(process.argv[2], name)).href);
const {Stage} = await from("lessons/stage.js");
const {labAddress, viewimitAddress} = await from("lessons/elsewhere.js");
const {fromAddress} = await from("view/address.js");

let text = "";
for await (const part of process.stdin) text += part;
const {pages, lab} = JSON.parse(text), found = [];
const plain = ({page, stage, ...scene}) => JSON.stringify(Object.entries(scene).sort());
for (const page of pages) for (const lesson of page.lessons) for (const step of lesson.steps) {
  for (let seed = 1; seed <= (step.samples?.length ?? 1); seed++) {
    const one = new Stage(page, step, {seed}), address = labAddress(one, "here"), wrong = [], {state} = one;
    const opened = address && fromAddress(address, lab.presets, lab.scenes, wrong);
    const scene = opened && lab.scenes[lab.presets.find(({name}) => name === opened.preset).scene];
    const turned = opened && Math.max(...opened.start.map((v, k) => Math.abs(v - one.moment.theta[k])));
    for (const [name, all] of Object.entries(one.variants)) one.slide(name, all[1].value);
    found.push({step: `${lesson.name}/${step.id}`, scene: state.scene, preset: opened?.preset ?? null, wrong, turned,
      isSame: opened ? plain(scene) === plain(one.scene) : null, viewimit: Boolean(viewimitAddress(new Stage(page, step, {seed}))),
      moved: Object.keys(one.variants).length ? [labAddress(one, ""), viewimitAddress(one)] : null});
  }
}
process.stdout.write(JSON.stringify(found));
