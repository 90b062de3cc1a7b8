/** node registered.mjs LESSONS: the figures with their layers, and the measures, that the modules have. */
import {pathToFileURL} from "node:url";

const load = path => import(pathToFileURL(`${process.argv[2]}/${path}`).href);
const [{FIGURES}, {MEASURES}, ...groups] = await Promise.all(["figures/registry.js", "measures.js",
  ...["ray", "tour", "jacobian", "limits"].map(name => `measures_${name}.js`)].map(load));
const figures = Object.fromEntries(Object.entries(FIGURES).map(([name, {layers}]) => [name, layers]));
process.stdout.write(JSON.stringify({figures, measures: Object.keys(MEASURES).sort(),
  ofGroups: groups.flatMap(group => Object.entries(group).filter(([name]) => name.endsWith("_MEASURES"))
    .flatMap(([, all]) => Object.keys(all)))}));
