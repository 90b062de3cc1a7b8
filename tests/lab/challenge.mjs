/** node challenge.mjs LAB: questions about the rules of challenges on standard input, answers on standard output. */
import {pathToFileURL} from "node:url";

let asked = "";
for await (const part of process.stdin) asked += part;
const {scene, days, levels, pairs, hashes, games} = JSON.parse(asked), lab = process.argv[2];
const load = path => import(pathToFileURL(`${lab}/${path}`).href);
const {World} = await load("engine/engine.js"), rules = await load("challenge/rules.js"), {Game} = await load("challenge/game.js");
const world = new World(scene, rules.POINTS), digits = "0123456789abcdefghijklmnopqrstuvwxyz";
const whole = ({demonstrator, start}) => [...demonstrator, ...start].map(v => Math.round(v * 180 / Math.PI));
const told = one => one && {...one, whole: whole(one), robot: rules.robotSteps(world, one), link: rules.toLink(one)};
const posed = ([demonstrator, start, level]) => ({demonstrator, start, level, by: "", day: ""});
const typos = word => [...word].flatMap((was, k) => [...digits].filter(other => other !== was).map(other =>
  word.slice(0, k) + other + word.slice(k + 1)));
process.stdout.write(JSON.stringify({
  days: days.flatMap(day => levels.map(level => told(rules.daily(world, day, level)))),
  refusals: pairs.map(pair => rules.refusal(world, posed(pair))),
  made: pairs.map(pair => {
    const made = rules.fromPose(world, {...posed(pair), by: "  Mia\n<b> and all of her many friends"});
    return typeof made === "string" ? made : told(made);
  }),
  read: hashes.map(hash => told(rules.fromLink(world, hash))),
  typos: pairs.map(pair => typos(rules.wordOf(posed(pair))).map(word => rules.fromLink(world, `#challenge=${word}`)).filter(Boolean).length),
  games: games.map(({hash, moves}) => {
    const game = new Game(world, rules.fromLink(world, hash));
    for (const theta of moves) game.step(theta);
    return {verdict: game.verdict, fact: game.fact, isOver: game.isOver, line: game.line("", false)};
  }),
}));
