/** node lesson_geometry.mjs LAB: what the lessons' own computations give; Python compares it with the library. */
import {pathToFileURL} from "node:url";

let asked = "";
for await (const part of process.stdin) asked += part;
const load = path => import(pathToFileURL(`${process.argv[2]}/${path}`).href);
const [engine, rays, showing, places, measures] = await Promise.all(["engine/engine.js", "lessons/rays.js",
  "lessons/teach_by_showing.js", "lessons/places.js", "lessons/measures_ray.js"].map(load));
const {scene, tasks, alike, postures, carried} = JSON.parse(asked), world = new engine.World(scene, 10);
const five = new engine.World(scene, 5), settings = {transfer: "epipolar", servo: "broyden"};

/** A stage as far as these functions read it. */
const stageOf = (demonstrator, start, distance = 1) => {
  const session = new engine.Session(world, {...settings, demonstrator, start});
  return {world, scene, session, moment: session.now, state: {points: 10}, sliders: new Map([["camera distance", distance]])};
};
const matchesOf = (demonstrator, own) => {
  const l = five.look("demonstrator", demonstrator).images, L = five.look("learner", own).images;
  return five.body.map((_, i) => [[l[4 * i], l[4 * i + 1]], [L[4 * i], L[4 * i + 1]]]);
};

process.stdout.write(JSON.stringify({
  runs: tasks.map(task => {
    const {postures: visited} = showing.teachByShowing(world, task);
    return {postures: visited};
  }),
  fifth: postures.map(own => measures.fifthLeftOut(matchesOf(alike, own))),
  carried: carried.map(by => places.energyMoved(stageOf(alike, postures[1]), by)),
  far: [0.4, 1, 2, 10].map(distance => {
    const stage = stageOf(alike, alike, distance), [first, second] = rays.camerasOf(stage);
    const marks = rays.marksOf(stage), lines = marks.map(p => rays.rayLine(second, first, p));
    const target = engine.projectPoint(second, rays.targetOf(stage)), e = rays.epipole(second, first);
    return {
      angle: rays.angleBetween(lines[0], lines[2]), epipole: Math.hypot(e[0] - target[0], e[1] - target[1]), target,
      off: marks.map((p, k) => Math.abs(lines[k].a * e[0] + lines[k].b * e[1] + lines[k].c)),
    };
  }),
  second: rays.twoCameras(world)[1],
  slide: [0, 0.22, 0.5, 0.82, 1].map(reveal => rays.sliding(reveal).share),
  onRay: [0.5, 1.3].map(share => rays.movedInPicture1(world, rays.seenFromOutside(rays.onRay(world.scene.cameras[0], rays.markOf(world), share)))),
  beside: rays.movedInPicture1(world, rays.seenFromOutside(rays.markOf(world)).map((v, k) => v + (k ? 0 : 30))),
}));
