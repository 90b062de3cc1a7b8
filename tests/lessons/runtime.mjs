/** node runtime.mjs LESSONS: a page's data on standard input, what the runtime makes of it on standard output. */
import path from "node:path";
import {pathToFileURL} from "node:url";

const from = name => import(pathToFileURL(path.join(process.argv[2], name)).href);
const {shuffledOrder, Stage} = await from("stage.js");
const {isAnswered, isRight, reply} = await from("answers.js");
const {fill, measure} = await from("measures.js");
const {distance} = await from("measured.js");
const {gain, orderOf, outcome, rightOf} = await from("questions.js");

let text = "";
for await (const part of process.stdin) text += part;
const page = JSON.parse(text), {steps} = page.lessons[0];
const of = (id, how) => new Stage(page, steps.find(step => step.id === id), how);
const said = stage => ({answered: isAnswered(stage), right: isRight(stage), reply: fill(reply(stage), stage)});
const DEGREE = Math.PI / 180, found = {};

const place = of("place"), truth = measure(place, "the place").value;
found.places = [[truth[0] + 3, truth[1]], [truth[0] + 60, truth[1]]].map(mark => (place.mark = mark, {...said(place), apart: measure(place, "distance in px")}));
place.step.ask.elsewhere = [{truth: "the place", near: 5, because: "There."}];
place.mark = [truth[0] + 4, truth[1]];
found.elsewhere = said(place).reply;
found.toLine = distance([5, 3], [[0, 0], [10, 0], [10, 10]]);

const number = of("number"), E = measure(number, "E").value;
found.numbers = [E * 1.4, E / 1.6, E * 1.6].map(value => (number.answer = {number: value}, said(number)));

const servo = of("servo", {seed: 4});
servo.slide("own 1", 33);
servo.move([40 * DEGREE, -100 * DEGREE]);
servo.move(servo.state.demonstrator);
const bowl = of("bowl", {previous: servo});
found.carried = {seed: bowl.seed, motions: bowl.motions.length, demonstrator: bowl.state.demonstrator.every((v, k) => v === servo.state.demonstrator[k]), goal: bowl.goal, at: bowl.moment.theta.map(v => v / DEGREE)};
bowl.unit = "rad";
bowl.mark = bowl.landscape().minimum.theta.map((v, k) => v + (k ? 0 : 10 * DEGREE));
found.onMap = {...said(bowl), apart: measure(bowl, "distance in degrees").text};

const pose = of("pose");
pose.answer = {pose: [60, -115]};
found.pose = {...said(pose), apart: measure(pose, "distance in degrees").value};
pose.slide("guess 1", 70);
found.guessed = pose.guessed.map(v => v / DEGREE);

const knobs = of("knobs", {seed: 5});
knobs.sliders.set("knob 1", 10);
found.knobs = {turns: knobs.knobbed.map((v, k) => (v - knobs.moment.theta[k]) / DEGREE), seeds: Array.from({length: 40}, (_, seed) => of("knobs", {seed: seed + 1}).knobs)};
const apart = of("choice");
apart.slide("pose apart", 0);
found.alike = apart.moment.theta.map((v, k) => (v - apart.moment.thetaDemo[k]) / DEGREE);
apart.slide("demo 2", -90);
found.demo = apart.moment.thetaDemo[1] / DEGREE;

found.orders = Array.from({length: 200}, (_, person) => orderOf({answers: [1, 2, 3, 4]}, 3, person, "before"));
found.orderAgain = [orderOf({answers: [1, 2, 3, 4]}, 3, 12, "before"), shuffledOrder(4, 12 * 64 + 6)];
const questions = page.lessons[0].questions, all = count => Object.fromEntries(questions.map(({id}, k) => [id, {answer: 0, right: k < count, sure: true, seconds: 1}]));
found.gains = [gain(4, 7, 8), gain(8, 8, 8), gain(4, 2, 8), rightOf(questions, all(5))];
found.outcomes = [outcome(questions, all(4), all(7)), outcome(questions, all(8), all(8)), outcome(questions, all(4), {})];

process.stdout.write(JSON.stringify(found));
