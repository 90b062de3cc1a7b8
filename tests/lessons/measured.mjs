/** node measured.mjs LESSONS: a page's data on standard input; figures, measures and their texts at the start of steps. */
import path from "node:path";
import {pathToFileURL} from "node:url";

const from = name => import(pathToFileURL(path.join(process.argv[2], name)).href);
const {Stage} = await from("stage.js");
const {measure, MEASURES} = await from("measures.js");
const {FIGURES} = await from("figures/registry.js");

let text = "";
for await (const part of process.stdin) text += part;
const {page, asked} = JSON.parse(text), texts = [];
for (const [lesson, id, name] of asked) {
  const step = page.lessons.find(one => one.name === lesson).steps.find(one => one.id === id);
  const stage = new Stage(page, step);
  texts.push(measure(stage, name).text);
}
const figures = Object.fromEntries(Object.entries(FIGURES).map(([name, {layers}]) => [name, layers]));
process.stdout.write(JSON.stringify({texts, figures, measures: Object.keys(MEASURES)}));
