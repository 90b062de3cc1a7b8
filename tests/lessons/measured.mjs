/** node measured.mjs LESSONS: the figures with their layers, and the measures. */
import path from "node:path";
import {pathToFileURL} from "node:url";

const from = name => import(pathToFileURL(path.join(process.argv[2], name)).href);
const {MEASURES} = await from("measures.js");
const {FIGURES} = await from("figures/registry.js");

const figures = Object.fromEntries(Object.entries(FIGURES).map(([name, {layers}]) => [name, layers]));
process.stdout.write(JSON.stringify({figures, measures: Object.keys(MEASURES)}));
