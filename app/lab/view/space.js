/**
 * A small WebGL view of the scene: two arms, the head, its image plates, points and lines. Matt, with one light and its
 * shadow. It knows no kinematics: it is given where the links are.
 * @typedef {[number, number, number]} Vector
 * @typedef {"demonstrator" | "learner"} Who
 * @typedef {{low: number[], step: number[], vertices: [number, number], faces: [number, number], wide: boolean}}
 * Mesh where in the packed bytes its vertices and faces are, and how to read them
 * @typedef {Mesh & {link: number}} LinkMesh
 * @typedef {Object} Stage what stands still in a scene
 * @property {number} size of the scene; 1 with a robot of a metre
 * @property {(Mesh & {colour: string, T: number[]})[]} solids T: 3 x 4, row by row
 * @property {{text: string, role: string, at: Vector}[]} labels
 * @property {{role: Who, eye: Vector, edges: [Vector, Vector][], plate: Vector[]}[]} frusta
 * @property {Vector[]} landmarks what the first view must hold
 * @property {Record<Who, number>} points m across
 * @typedef {{links: LinkMesh[], looks: Record<string, any>, view: {fov: number, margin: number, azimuth: number,
 * elevation: number}}} Common what all scenes of a robot share
 * @typedef {Object} Shown what moves
 * @property {Record<Who, ArrayLike<number>[]>} frames T_world_link of every link, 3 x 4, row by row
 * @property {Record<Who, Vector[]>} points body points
 * @property {(project: (p: ArrayLike<number>) => Vector) => void} [painted] draws over the canvas
 * @property {(Vector | null)[][]} plates each point on the four image plates
 * @property {(Vector | null)[]} recovered
 * @property {boolean} [rays] whether all points are joined with their images
 * @property {[Vector, Vector, string, number, number][]} [lines] from, to, role, width px, opacity */
import {cross, dot, unit as normalised} from "../engine/algebra.js";
import {distance} from "../lessons/measured.js";
import {perFrame} from "./page.js";
import {LINE_FS, LINE_VS, FLAT_FS, FLOOR_FS, SOLID_FS, SOLID_VS} from "./shaders.js";

const VIEWS = ["l", "r", "L", "R"], NAME_PX = 13, ROOM_PX = 9; // of an image's name from its plate, and from any line
const SLOW_MS = 150, MEASURED = 4; // a frame that is too slow, and how many of the first are measured
const SHADOW_PX = 1600, FLOATS_PER_CORNER = 13;
const ATTRIBUTES = ["place", "normal", "one", "other", "corner", "tint"];
const ROLES = ["learner", "demonstrator", "recovered", "residual", "paper", "secondary", "chosen"];

/** @param {Vector} a @param {Vector} b @param {number} [s] @returns {Vector} */
const sum = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
/** @param {Vector} a @returns {Vector} */
const unit = a => /** @type {Vector} */ (normalised(a));

/** A 4 x 4 matrix column by column, as WebGL has it, of a transform 3 x 4 row by row. @param {ArrayLike<number>} T */
const columns = T => Float32Array.of(T[0], T[4], T[8], 0, T[1], T[5], T[9], 0, T[2], T[6], T[10], 0, T[3], T[7], T[11], 1);
/** @param {Vector} p @param {number} [s] */
const placed = ([x, y, z], s = 1) => Float32Array.of(s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, x, y, z, 1);
const UNMOVED = placed([0, 0, 0]);
/** @param {Float32Array} a @param {Float32Array} b */
const product = (a, b) => Float32Array.from({length: 16}, (_, i) => {
  let found = 0;
  for (let k = 0; k < 4; k++) found += a[4 * k + i % 4] * b[i - i % 4 + k];
  return found;
});
/** @param {Vector} right @param {Vector} up @param {Vector} back @param {Vector} eye */
const viewed = (right, up, back, eye) => columns([right, up, back].flatMap(axis => [...axis, -dot(axis, eye)]));
/** @param {number} fov @param {number} aspect @param {number} near @param {number} far */
const perspective = (fov, aspect, near, far) => {
  const f = 1 / Math.tan(fov / 2);
  return Float32Array.of(f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0);
};
/** @param {number} half @param {number} near @param {number} far */
const orthographic = (half, near, far) =>
  Float32Array.of(1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -2 / (far - near), 0, 0, 0, -(far + near) / (far - near), 1);

/** @returns {Vector[]} the corners of eight triangles */
function octahedron() {
  /** @type {Vector[]} */
  const corners = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
  return [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5].map(k => corners[k]);
}

/** An octahedron, three times divided. */
function sphere() {
  let corners = octahedron();
  for (let times = 0; times < 3; times++) {
    const finer = [];
    for (let f = 0; f < corners.length; f += 3) {
      const [a, b, c] = corners.slice(f, f + 3), ab = unit(sum(a, b)), bc = unit(sum(b, c)), ca = unit(sum(c, a));
      finer.push(a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca);
    }
    corners = finer;
  }
  return corners;
}

/** @param {Float32Array} places @param {ArrayLike<number>} faces */
function normalsOf(places, faces) {
  const normals = new Float32Array(places.length);
  /** @param {number} k @returns {Vector} */
  const corner = k => [places[3 * k], places[3 * k + 1], places[3 * k + 2]];
  for (let f = 0; f < faces.length; f += 3) {
    const a = corner(faces[f]), n = cross(sum(corner(faces[f + 1]), a, -1), sum(corner(faces[f + 2]), a, -1));
    for (let k = 0; k < 3; k++) for (let i = 0; i < 3; i++) normals[3 * faces[f + k] + i] += n[i];
  }
  for (let v = 0; v < normals.length; v += 3) {
    const length = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1;
    for (let i = 0; i < 3; i++) normals[v + i] /= length;
  }
  return normals;
}

/** @param {HTMLCanvasElement} canvas @param {HTMLElement} labelsIn over the canvas @param {Common} common
 * @param {ArrayBuffer} meshes @param {(() => void) | null} slow is called once if the first frames take too long
 * @returns {ReturnType<typeof spaceOn> | null} null without WebGL 2 */
export function openSpace(canvas, labelsIn, common, meshes, slow) {
  const gl = canvas.getContext("webgl2", {antialias: true, alpha: false, preserveDrawingBuffer: true});
  return gl && spaceOn(gl, canvas, labelsIn, common, meshes, slow);
}

/** @param {WebGL2RenderingContext} gl @param {HTMLCanvasElement} canvas @param {HTMLElement} labelsIn
 * @param {Common} common @param {ArrayBuffer} meshes @param {(() => void) | null} slow */
function spaceOn(gl, canvas, labelsIn, common, meshes, slow) {
  /** @param {string} vs @param {string} fs */
  const program = (vs, fs) => {
    const made = gl.createProgram();
    for (const [kind, text] of /** @type {const} */ ([[gl.VERTEX_SHADER, vs], [gl.FRAGMENT_SHADER, fs]])) {
      const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw Error(gl.getShaderInfoLog(shader) ?? "no shader");
      gl.attachShader(made, shader);
    }
    ATTRIBUTES.forEach((name, k) => gl.bindAttribLocation(made, k, name));
    gl.linkProgram(made);
    const known = /** @type {Record<string, WebGLUniformLocation | null>} */ ({});
    return {made, at: (/** @type {string} */ name) => name in known ? known[name] : known[name] = gl.getUniformLocation(made, name)};
  };
  /** @typedef {ReturnType<typeof program>} Program */
  const solid = program(SOLID_VS, SOLID_FS), flat = program(SOLID_VS, FLAT_FS), floor = program(SOLID_VS, FLOOR_FS), line = program(LINE_VS, LINE_FS);

  /** @param {Float32Array<ArrayBuffer>} places @param {Float32Array<ArrayBuffer>} normals
   * @param {Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer>} faces */
  const shape = (places, normals, faces) => {
    const made = gl.createVertexArray(), buffers = [places, normals].map((data, k) => {
      const buffer = gl.createBuffer();
      gl.bindVertexArray(made);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 0, 0);
      return buffer;
    });
    const indices = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    const free = () => { gl.deleteVertexArray(made); [...buffers, indices].forEach(buffer => gl.deleteBuffer(buffer)); };
    return {made, free, count: faces.length, type: faces.BYTES_PER_ELEMENT === 4 ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT};
  };
  /** @typedef {ReturnType<typeof shape>} Shape */
  /** @param {Mesh} mesh */
  const unpacked = mesh => {
    const steps = new Uint16Array(meshes, mesh.vertices[0], 3 * mesh.vertices[1]);
    const faces = new (mesh.wide ? Uint32Array : Uint16Array)(meshes, mesh.faces[0], mesh.faces[1]);
    const places = Float32Array.from(steps, (v, i) => mesh.low[i % 3] + v * mesh.step[i % 3]);
    return shape(places, normalsOf(places, faces), faces);
  };
  /** @param {Vector[]} corners @param {boolean} [round] */
  const ownShape = (corners, round) => {
    const places = new Float32Array(corners.flat()), faces = Uint16Array.from(corners, (_, k) => k);
    return shape(places, round ? places : normalsOf(places, faces), faces);
  };
  const links = common.links.map(mesh => ({link: mesh.link, shape: unpacked(mesh)}));
  const ball = ownShape(sphere(), true), diamond = ownShape(octahedron());

  const corners = gl.createBuffer(), lineArray = gl.createVertexArray();
  gl.bindVertexArray(lineArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, corners);
  [[2, 3, 0], [3, 3, 3], [4, 3, 6], [5, 4, 9]].forEach(([k, count, from]) => {
    gl.enableVertexAttribArray(k);
    gl.vertexAttribPointer(k, count, gl.FLOAT, false, 4 * FLOATS_PER_CORNER, 4 * from);
  });
  gl.bindVertexArray(null);

  const shadow = gl.createTexture(), shadowIn = gl.createFramebuffer();
  gl.bindTexture(gl.TEXTURE_2D, shadow);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_PX, SHADOW_PX);
  for (const [name, value] of [
    [gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE],
    [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
  ]) gl.texParameteri(gl.TEXTURE_2D, name, value);
  gl.bindFramebuffer(gl.FRAMEBUFFER, shadowIn);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, shadow, 0);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  const sun = unit([-2, -3, 5]), sunRight = unit(cross([0, 0, 1], sun)), sunUp = cross(sun, sunRight);

  // What stands still
  /** @type {{size: number, stage: Stage, solids: {T: Float32Array, colour: string, shape: Shape}[], plates: Shape[],
   * ground: Shape, middle: Vector, wide: number, lit: Float32Array, labels: Name[]}} */
  let set;
  /** @param {Stage} stage */
  const setStage = stage => {
    if (set) {
      [...set.solids.map(({shape: what}) => what), ...set.plates, set.ground].forEach(what => what.free());
      labelsIn.replaceChildren();
    }
    const {landmarks} = stage;
    /** @type {Vector} */
    const middle = [0, 0, 0];
    for (const p of landmarks) for (let i = 0; i < 3; i++) middle[i] += p[i] / landmarks.length;
    const reach = Math.max(...landmarks.map(p => Math.hypot(...sum(p, middle, -1)))) * 1.15, wide = 4 * reach;
    /** @type {Vector[]} */
    const square = [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]].map(([x, y]) => [middle[0] + x * wide, middle[1] + y * wide, 0]);
    const labels = stage.labels.map(({text, role, at}) => {
      const label = labelsIn.appendChild(document.createElement("span"));
      label.textContent = text;
      label.classList.toggle("eye", VIEWS.includes(text));
      label.style.color = `var(--${role === "demonstrator" ? "demonstrator-edge" : role})`;
      return {label, at, view: VIEWS.indexOf(text), place: -1};
    });
    set = {
      size: stage.size, stage, middle, wide, labels, ground: ownShape(square),
      solids: stage.solids.map(one => ({T: columns(one.T), colour: one.colour, shape: unpacked(one)})),
      plates: stage.frusta.map(({plate}) => ownShape([0, 1, 2, 0, 2, 3].map(k => plate[k]))),
      lit: product(orthographic(reach, .1, 4 * reach), viewed(sunRight, sunUp, sun, sum(middle, sun, 2 * reach))),
    };
    fit();
  };

  // Colours, of the stylesheet's roles
  const colours = /** @type {Record<string, number[]>} */ ({});
  let look = common.looks.light;
  const recolour = () => {
    look = common.looks[document.documentElement.dataset.scheme === "dark" ? "dark" : "light"];
    const style = getComputedStyle(document.documentElement);
    for (const role of ROLES) {
      const hex = style.getPropertyValue(`--${role}`).trim();
      colours[role] = [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16));
    }
    for (const name of ["pedestal", "metal", "lens", "plate", "cells", "sections"]) colours[name] = look[name];
    // One tint in both schemes, of which each makes its own by its light
    colours.learnerArm = [0, 114, 178].map(c => (c + 255) >> 1);
    colours.demonstratorArm = [230, 159, 0].map(c => (c + 255) >> 1);
    later();
  };

  // The camera: azimuth and elevation about a target
  const {fov, margin} = common.view;
  let {azimuth, elevation} = common.view, distance = 1, untouched = true;
  /** @type {Vector} */
  let target = [0, 0, 0];
  /** @returns {[Vector, Vector, Vector]} right, up, back */
  const axes = () => {
    const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
    /** @type {Vector} */
    const back = [ce * ca, ce * sa, se], right = /** @type {Vector} */ ([-sa, ca, 0]);
    return [right, cross(back, right), back];
  };
  const aspect = () => Math.max(canvas.clientWidth, 1) / Math.max(canvas.clientHeight, 1);
  /** As near as all landmarks are in sight: opposite sides of the frame bound the eye. */
  const fit = () => {
    ({azimuth, elevation} = common.view);
    const [right, up, back] = axes(), tan = Math.tan(fov / 2) * margin, {landmarks} = set.stage;
    const place = landmarks.map(p => [right, up, back].map(axis => dot(p, axis)));
    const most = (/** @type {(p: number[]) => number} */ of) => Math.max(...place.map(of));
    const found = [[0, tan * aspect(), tan * aspect()], [1, tan * .86, tan * .94]].map(([k, slope, below]) => {
      const high = most(p => p[k] + slope * p[2]), low = -most(p => below * p[2] - p[k]);
      return {distance: (high - low) / (slope + below), slope, below, high, low};
    });
    const eye = Math.max(found[0].distance, found[1].distance);
    const at = found.map(({slope, below, high, low}) => (high - slope * eye + low + below * eye) / 2);
    const depth = eye - place.reduce((total, p) => total + p[2], 0) / place.length;
    distance = depth;
    target = sum(sum(sum([0, 0, 0], right, at[0]), up, at[1]), back, eye - depth);
    untouched = true;
    later();
  };
  const seenBy = () => {
    const [right, up, back] = axes();
    return product(perspective(fov, aspect(), .02 * set.size, 60 * set.size), viewed(right, up, back, sum(target, back, distance)));
  };
  /** Where a point of the world is drawn: px from the canvas's corner, and depth.
   * @param {ArrayLike<number>} p @returns {Vector} */
  const project = (p, seen = seenBy()) => {
    const [x, y, , w] = [0, 1, 2, 3].map(i => seen[i] * p[0] + seen[4 + i] * p[1] + seen[8 + i] * p[2] + seen[12 + i]);
    return [(x / w + 1) / 2 * canvas.clientWidth, (1 - y / w) / 2 * canvas.clientHeight, w];
  };

  const spans = /** @type {number[]} */ ([]);
  /** @param {ArrayLike<number>} a @param {ArrayLike<number>} b @param {number[]} colour @param {number} width
   * @param {number} [alpha] */
  const addLine = (a, b, colour, width, alpha = 1) => {
    for (const [end, side] of [[0, -1], [0, 1], [1, 1], [0, -1], [1, 1], [1, -1]])
      spans.push(a[0], a[1], a[2], b[0], b[1], b[2], end, end ? -side : side, width, colour[0] / 255, colour[1] / 255, colour[2] / 255, alpha);
  };
  /** @param {Program} how @param {Shape} what @param {Float32Array} model @param {number[]} [colour]
   * @param {number} [alpha] */
  const draw = (how, what, model, colour, alpha = 1) => {
    gl.uniformMatrix4fv(how.at("model"), false, model);
    if (colour) gl.uniform4f(how.at("colour"), ...linear(colour), alpha);
    gl.bindVertexArray(what.made);
    gl.drawElements(gl.TRIANGLES, what.count, what.type, 0);
  };
  /** @param {Program} how @param {Shown} shown */
  const drawSolids = (how, {frames}) => {
    for (const who of /** @type {Who[]} */ (["demonstrator", "learner"]))
      for (const {link, shape: what} of links) draw(how, what, columns(frames[who][link]), colours[`${who}Arm`]);
    for (const {T, colour, shape: what} of set.solids) draw(how, what, T, colours[colour]);
  };
  let shown = /** @type {Shown | null} */ (null);
  const resize = () => {
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const [w, h] = [canvas.clientWidth, canvas.clientHeight].map(px => Math.max(1, Math.round(px * ratio)));
    if (canvas.width === w && canvas.height === h) return;
    [canvas.width, canvas.height] = [w, h];
    if (untouched && set) fit();
  };
  const paint = () => {
    const began = performance.now();
    if (!shown || !set || gl.isContextLost()) return;
    resize();
    const {points, plates, recovered} = shown, {size} = set, seen = seenBy();
    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, shadowIn);
    gl.viewport(0, 0, SHADOW_PX, SHADOW_PX);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(flat.made);
    gl.uniformMatrix4fv(flat.at("seen"), false, set.lit);
    drawSolids(flat, shown);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(colours.paper[0] / 255, colours.paper[1] / 255, colours.paper[2] / 255, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.bindTexture(gl.TEXTURE_2D, shadow);
    for (const how of [floor, solid, flat]) {
      gl.useProgram(how.made);
      gl.uniformMatrix4fv(how.at("seen"), false, seen);
      gl.uniformMatrix4fv(how.at("lit"), false, set.lit);
    }
    gl.useProgram(floor.made);
    for (const name of ["paper", "cells", "sections"]) gl.uniform3fv(floor.at(name), colours[name].map(c => c / 255));
    gl.uniform4f(floor.at("around"), set.middle[0], set.middle[1], set.wide * .8, size);
    draw(floor, set.ground, UNMOVED);
    gl.useProgram(solid.made);
    gl.uniform3fv(solid.at("sun"), sun);
    gl.uniform2f(solid.at("power"), look.sky, look.sun);
    drawSolids(solid, shown);
    points.learner.forEach(p => draw(solid, ball, placed(p, set.stage.points.learner / 2), colours.learner));
    points.demonstrator.forEach(p => draw(solid, diamond, placed(p, set.stage.points.demonstrator / 2), colours.demonstrator));

    spans.length = 0;
    set.stage.frusta.forEach(({role, edges}) => edges.forEach(([a, b]) => addLine(a, b, colours[role], 1.6)));
    recovered.forEach((p, i) => {
      if (!p) return;
      draw(solid, diamond, placed(p, .01 * size), colours.recovered);
      addLine(p, points.learner[i], colours.residual, 3);
    });
    gl.useProgram(flat.made);
    plates.forEach((marks, k) => marks.forEach((p, i) => {
      /** @type {Who} */
      const who = k < 2 ? "demonstrator" : "learner";
      if (!p) return;
      draw(flat, ball, placed(p, .0045 * size), colours[who]);
      if (shown?.rays) addLine(p, points[who][i], colours[who], 1, .35);
    }));
    for (const [a, b, role, width, alpha] of shown.lines ?? []) addLine(a, b, colours[role], width, alpha);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    set.plates.forEach(what => draw(flat, what, UNMOVED, colours.plate, .55));
    gl.useProgram(line.made);
    gl.uniformMatrix4fv(line.at("seen"), false, seen);
    gl.uniform2f(line.at("size"), canvas.clientWidth, canvas.clientHeight);
    gl.bindVertexArray(lineArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, corners);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(spans), gl.DYNAMIC_DRAW);
    gl.drawArrays(gl.TRIANGLES, 0, spans.length / FLOATS_PER_CORNER);
    gl.depthMask(true);
    gl.bindVertexArray(null);

    shown.painted?.(p => project(p, seen));
    const frusta = set.stage.frusta.map(({edges}) => edges.map(ends => ends.map(p => project(p, seen))));
    for (const one of set.labels) {
      const {label, at, view} = one, w = project(at, seen)[2];
      const [x, y] = view < 0 ? project(at, seen) : beside(frusta, view, one);
      label.hidden = w <= 0;
      label.style.transform = `translate(${x}px,${y}px) translate(-50%,-50%)`;
    }
    if (slow && took.length < MEASURED) measure(performance.now() - began);
  };
  const took = /** @type {number[]} */ ([]); // ms of the first frames
  /** Wait until a frame is drawn; the first also takes the time to make the programs ready. @param {number} asked ms */
  const measure = asked => {
    const began = performance.now();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    took.push(asked + performance.now() - began);
    if (took.length > 1 && Math.min(...took) > SLOW_MS) {
      took.length = MEASURED;
      slow?.();
    } else later();
  };
  const later = perFrame(paint);

  // Hands: one turns, two pinch and shift; the wheel zooms where it does not scroll
  const hands = /** @type {Map<number, {x: number, y: number}>} */ (new Map());
  const turn = (/** @type {number} */ dx, /** @type {number} */ dy) => {
    azimuth -= .008 * dx;
    elevation = Math.min(1.5, Math.max(-.15, elevation + .008 * dy));
    untouched = false;
    later();
  };
  const shift = (/** @type {number} */ dx, /** @type {number} */ dy) => {
    const [right, up] = axes(), px = 2 * distance * Math.tan(fov / 2) / canvas.clientHeight;
    target = sum(sum(target, right, -dx * px), up, dy * px);
    untouched = false;
    later();
  };
  const zoom = (/** @type {number} */ by) => {
    distance = Math.min(30 * set.size, Math.max(.2 * set.size, distance * by));
    untouched = false;
    later();
  };
  const spread = () => {
    const [a, b] = [...hands.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    hands.set(event.pointerId, {x: event.clientX, y: event.clientY});
  });
  canvas.addEventListener("pointermove", event => {
    const before = hands.get(event.pointerId);
    if (!before) return;
    const wide = hands.size === 2 ? spread() : 0, dx = event.clientX - before.x, dy = event.clientY - before.y;
    hands.set(event.pointerId, {x: event.clientX, y: event.clientY});
    if (hands.size === 2) {
      zoom(wide / spread());
      shift(dx / 2, dy / 2);
    } else if (event.buttons & 2 || event.shiftKey) shift(dx, dy);
    else turn(dx, dy);
  });
  for (const name of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"]))
    canvas.addEventListener(name, event => hands.delete(event.pointerId));
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    const scrolls = document.documentElement.scrollHeight > innerHeight + 1;
    if (scrolls && !event.ctrlKey) return;
    event.preventDefault();
    zoom(Math.exp(.0012 * event.deltaY));
  }, {passive: false});
  canvas.addEventListener("keydown", event => {
    const turns = {ArrowUp: [0, 20], ArrowDown: [0, -20], ArrowRight: [-20, 0], ArrowLeft: [20, 0]}[event.key];
    if (turns) turn(turns[0], turns[1]);
    else if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? .9 : 1.1);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  new ResizeObserver(later).observe(canvas);
  recolour();
  resize();
  return {setStage, fit, recolour, turn, zoom, project, isTurned: () => !untouched, show: (/** @type {Shown | null} */ what) => { shown = what; later(); }};
}

/** A name in the scene. view: 0 … 3 for the name of an image, -1 for others; place: of the eight around its plate.
 * @typedef {{label: HTMLElement, at: Vector, view: number, place: number}} Name */

/** Where the name of an image is drawn: outside its plate, away from all lines. It stays there while it has room.
 * @param {Vector[][][]} frusta their edges on the canvas: four of the plate, four to the eye @param {number} view
 * @param {Name} name */
function beside(frusta, view, name) {
  const corners = frusta[view].slice(0, 4).map(([from]) => from), mean = (/** @type {Vector[]} */ ...points) =>
    [0, 1].map(k => points.reduce((all, p) => all + p[k], 0) / points.length);
  const middle = mean(...corners), around = corners.flatMap((p, k) => [mean(p), mean(p, corners[(k + 1) % 4])]);
  const places = around.map(p => {
    const [x, y] = p.map((v, k) => v - middle[k]), out = 1 + NAME_PX / Math.max(Math.hypot(x, y), 1);
    return [middle[0] + out * x, middle[1] + out * y];
  });
  const room = places.map(place => Math.min(...frusta.flat().map(edge => distance(place, edge))));
  if (!(room[name.place] >= ROOM_PX)) name.place = room.indexOf(Math.max(...room));
  return places[name.place];
}

/** @param {number[]} colour 0 … 255 each @returns {Vector} */
const linear = colour => [(colour[0] / 255) ** 2.2, (colour[1] / 255) ** 2.2, (colour[2] / 255) ** 2.2];
