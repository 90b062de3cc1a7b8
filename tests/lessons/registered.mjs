/** node registered.mjs LESSONS: the figures with their layers, and the measures, that the modules have. */
import {pathToFileURL} from "node:url";

const load = path => import(pathToFileURL(`${process.argv[2]}/${path}`).href);
const [{FIGURES}, {MEASURES}] = await Promise.all(["figures/registry.js", "measures.js"].map(load));
const figures = Object.fromEntries(Object.entries(FIGURES).map(([name, {layers}]) => [name, layers]));
process.stdout.write(JSON.stringify({figures, measures: Object.keys(MEASURES)}));
