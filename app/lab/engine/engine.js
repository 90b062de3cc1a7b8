/**
 * The method of "View-Based Imitation Learning by Conflict Resolution with Epipolar Geometry" (IROS 2001) in the browser.
 *
 * The Python library is its oracle: tests hold every number here against it. A view needs:
 *
 *     const world = new World(scene, 10);                       // a scene as Python writes it, a layout of body points
 *     const session = new Session(world, {transfer: "epipolar", servo: "broyden", demonstrator: [...], start: [...]});
 *     session.step();                                           // one motion; false when the servo rests
 *     session.undo(); session.pose(theta); session.change({transfer: "linear"}); session.begin({...session.settings});
 *     session.now;                                              // the present Moment: postures, views, E, status
 *     recovered(session.now);                                   // the demonstrator's points, transferred to [L], [R]
 *     geometry(session.now).lines(demo, own);                   // the epipolar lines of a point
 *     const landscape = new Landscape(world, 2);                // E over both joints, in steps of 2°
 *     landscape.evaluate("epipolar", session.observer.demo(theta));
 *     reachFor(place, target, theta, lower, upper);             // the posture that brings something somewhere
 *
 * Angles are in radians, lengths in metres. Images are flat arrays: x, y of each point in the left view, x, y in the
 * right one. Nothing in this folder touches a document, so it runs in a worker and in Node as well.
 *
 * Read it in the paper's order: camera.js, affine.js (1)-(3), epipolar.js (4), transfers.js (6), landscape.js (Fig. 7),
 * gradient.js (13), session.js (the loop). broyden.js is the law that needs few motions; linear.js and projective.js are
 * two other transfers.
 */
export {EpipolarGeometry, PAIRS} from "./affine.js";
export {clamp, cross, DEGREE, dot, farthest, unit} from "./algebra.js";
export {backProject, projectPoint, triangulate} from "./camera.js";
export {reachFor, transform} from "./kinematics.js";
export {energyAt, Landscape, lowest, matched} from "./landscape.js";
export {draws, Generator} from "./random.js";
export {SERVOS} from "./servo.js";
export {geometry, MIN_POINTS, recovered, Session} from "./session.js";
export {conflict, residual, TRANSFERS} from "./transfers.js";
export {Observer, select, World} from "./world.js";
