/** node limits.mjs LESSONS: measures of steps as the browser computes them; Python compares them with the library. */
import {pathToFileURL} from "node:url";

let asked = "";
for await (const part of process.stdin) asked += part;
const load = path => import(pathToFileURL(`${process.argv[2]}/${path}`).href);
const [{Stage}, {MEASURES}, {waysOf}, {bestOrder, mapOfFirst}, mended, maps, {scores}] = await Promise.all(["stage.js",
  "measures.js", "figures/circle.js", "figures/matches.js", "figures/rectified.js", "maps.js", "figures/sign.js"].map(load));
const {page, cases} = JSON.parse(asked);

const found = {
  measures: (stage, names) => Object.fromEntries(names.map(name => [name, MEASURES[name](stage)])),
  smallest: stage => maps.stageSmallest(stage),
  order: stage => bestOrder(stage),
  largest: (stage, counts) => counts.map(count => Math.max(...mapOfFirst(stage, count).landscape.E)),
  mended: (stage, layer) => (layer === "rectified" ? mended.mappedRectified : mended.mappedAsSeen)(stage).least,
  carried: stage => waysOf(stage),
  scores: (stage, bets) => {
    stage.bets = bets;
    return scores(stage);
  },
};

process.stdout.write(JSON.stringify(cases.map(({step, sliders = {}, ask}) => {
  const stage = new Stage(page, step);
  for (const [name, value] of Object.entries(sliders)) stage.slide(name, value);
  return Object.fromEntries(Object.entries(ask).map(([name, of]) => [name, found[name](stage, of)]));
})));
