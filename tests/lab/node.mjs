/** node node.mjs ENGINE: questions on standard input, answers on standard output. */
import {pathToFileURL} from "node:url";
import {answers} from "./answers.js";

let asked = "";
for await (const part of process.stdin) asked += part;
const engine = await import(pathToFileURL(process.argv[2]).href);
process.stdout.write(answers(engine, JSON.parse(asked)));
