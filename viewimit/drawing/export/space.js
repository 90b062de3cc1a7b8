// A small WebGL view: arms by forward kinematics, furniture, points, lines; matt, with one light and its shadow.
"use strict";
const M4 = {
  one: () => new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
  mul(a, b) {
    const c = new Float32Array(16);
    for (let j = 0; j < 4; j++) for (let i = 0; i < 4; i++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + i] * b[4 * j + k];
      c[4 * j + i] = sum;
    }
    return c;
  },
  at: ([x, y, z], s = 1) => new Float32Array([s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, x, y, z, 1]),
  turn([x, y, z], angle) {  // Rodrigues
    const c = Math.cos(angle), s = Math.sin(angle), t = 1 - c;
    return new Float32Array([t * x * x + c, t * x * y + s * z, t * x * z - s * y, 0, t * x * y - s * z, t * y * y + c,
      t * y * z + s * x, 0, t * x * z + s * y, t * y * z - s * x, t * z * z + c, 0, 0, 0, 0, 1]);
  },
  apply: (m, [x, y, z]) => [0, 1, 2].map(i => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]),
  view(right, up, back, eye) {
    const rows = [right, up, back], m = M4.one();
    rows.forEach((row, i) => { row.forEach((v, j) => { m[4 * j + i] = v; }); m[12 + i] = -V3.dot(row, eye); });
    return m;
  },
  perspective(fov, aspect, near, far) {
    const f = 1 / Math.tan(fov / 2), m = new Float32Array(16);
    m[0] = f / aspect; m[5] = f; m[10] = (far + near) / (near - far); m[11] = -1; m[14] = 2 * far * near / (near - far);
    return m;
  },
  box(half, near, far) {
    const m = M4.one();
    m[0] = m[5] = 1 / half; m[10] = -2 / (far - near); m[14] = -(far + near) / (far - near);
    return m;
  },
};
const V3 = {
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  sum: (a, b, s = 1) => a.map((v, i) => v + s * b[i]),
  unit: a => { const n = Math.hypot(...a); return a.map(v => v / n); },
};
const SOLID_VS = `#version 300 es
in vec3 place; in vec3 normal; uniform mat4 model, seen, lit; out vec3 n; out vec3 at; out vec4 shade;
void main(){ vec4 p = model * vec4(place, 1.); n = mat3(model) * normal; at = p.xyz;
  shade = lit * (p + vec4(normalize(n) * .012, 0.)); gl_Position = seen * p; }`;
const SHADOW = `
uniform highp sampler2DShadow map;
float light(vec4 s){ vec3 p = s.xyz / s.w * .5 + .5; if (any(greaterThan(abs(p - .5), vec3(.5)))) return 1.;
  float sum = 0.; for (int i = -1; i < 2; i++) for (int j = -1; j < 2; j++)
    sum += texture(map, vec3(p.xy + vec2(i, j) / 1600., p.z - .0012)); return sum / 9.; }`;
const SOLID_FS = `#version 300 es
precision highp float; in vec3 n; in vec3 at; in vec4 shade; uniform vec4 colour; uniform vec3 sun; uniform vec2 power;
${SHADOW} out vec4 drawn;
void main(){ vec3 m = normalize(gl_FrontFacing ? n : -n);
  vec3 sky = mix(vec3(.44, .43, .49), vec3(.91, .90, 1.), .5 * m.z + .5) * power.x;
  float d = max(dot(m, sun), 0.); d *= d > 0. ? light(shade) : 0.;
  drawn = vec4(pow(min(colour.rgb * (sky + d * power.y) / 4., 1.), vec3(1. / 2.2)), 1.) * colour.a; }`;
const FLAT_FS = `#version 300 es
precision highp float; in vec3 n; in vec3 at; in vec4 shade; uniform vec4 colour; out vec4 drawn;
void main(){ drawn = vec4(pow(colour.rgb, vec3(1. / 2.2)), 1.) * colour.a; }`;
const FLOOR_FS = `#version 300 es
precision highp float; in vec3 n; in vec3 at; in vec4 shade; uniform vec3 paper, cells, sections; uniform vec4 around;
${SHADOW} out vec4 drawn;
float grid(vec2 p, float wide){ vec2 w = fwidth(p); vec2 g = abs(fract(p - .5) - .5);
  vec2 line = clamp(wide - g / w + .5, 0., 1.) * min(vec2(1.), .35 / w); return max(line.x, line.y); }
void main(){ float far = length(at.xy - around.xy) / around.z;
  vec3 c = mix(paper, cells, grid(at.xy / (.25 * around.w), .35)); c = mix(c, sections, grid(at.xy / around.w, .35));
  c *= 1. - .13 * (1. - light(shade)); c = mix(c, paper, smoothstep(.55, 1., far)); drawn = vec4(c, 1.); }`;
const LINE_VS = `#version 300 es
in vec3 one, other; in vec3 corner; in vec4 tint; uniform mat4 seen; uniform vec2 size; out vec4 colour;
void main(){ vec4 a = seen * vec4(one, 1.), b = seen * vec4(other, 1.);
  vec2 along = (b.xy / b.w - a.xy / a.w) * size; along /= max(length(along), 1e-6);
  vec4 p = corner.x > .5 ? b : a;
  p.xy += vec2(-along.y, along.x) * corner.y * corner.z / size * p.w; colour = tint; gl_Position = p; }`;
const LINE_FS = `#version 300 es
precision highp float; in vec4 colour; out vec4 drawn; void main(){ drawn = vec4(colour.rgb, 1.) * colour.a; }`;

// What turns a page's data into pictures on a canvas. null without WebGL 2.
function spaceOn(canvas, labelsIn, space, meshes) {
  const gl = canvas.getContext("webgl2", {antialias: true, alpha: false, preserveDrawingBuffer: true});
  if (!gl) return null;
  const NAMES = ["place", "normal", "one", "other", "corner", "tint"];
  const program = (vs, fs) => {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vs], [gl.FRAGMENT_SHADER, fs]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    NAMES.forEach((name, k) => gl.bindAttribLocation(made, k, name));
    gl.linkProgram(made);
    const at = {};
    return {made, at: name => name in at ? at[name] : (at[name] = gl.getUniformLocation(made, name))};
  };
  const solid = program(SOLID_VS, SOLID_FS), flat = program(SOLID_VS, FLAT_FS), floor = program(SOLID_VS, FLOOR_FS);
  const line = program(LINE_VS, LINE_FS);

  const buffer = (where, data) => {
    const made = gl.createBuffer();
    gl.bindBuffer(where, made);
    gl.bufferData(where, data, gl.STATIC_DRAW);
    return made;
  };
  const shape = (places, normals, faces) => {
    const made = gl.createVertexArray();
    gl.bindVertexArray(made);
    [places, normals].forEach((data, k) => {
      buffer(gl.ARRAY_BUFFER, data);
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 0, 0);
    });
    buffer(gl.ELEMENT_ARRAY_BUFFER, faces);
    gl.bindVertexArray(null);
    return {made, count: faces.length, type: faces.BYTES_PER_ELEMENT === 4 ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT};
  };
  const normalsOf = (places, faces) => {
    const normals = new Float32Array(places.length);
    for (let f = 0; f < faces.length; f += 3) {
      const [a, b, c] = [0, 1, 2].map(k => places.subarray(3 * faces[f + k], 3 * faces[f + k] + 3));
      const n = V3.cross([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
      for (let k = 0; k < 3; k++) for (let i = 0; i < 3; i++) normals[3 * faces[f + k] + i] += n[i];
    }
    for (let v = 0; v < normals.length; v += 3) {
      const length = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1;
      for (let i = 0; i < 3; i++) normals[v + i] /= length;
    }
    return normals;
  };
  const mesh = told => {
    const steps = new Uint16Array(meshes, told.vertices[0], 3 * told.vertices[1]);
    const faces = new (told.wide ? Uint32Array : Uint16Array)(meshes, told.faces[0], told.faces[1]);
    const places = Float32Array.from(steps, (v, i) => told.low[i % 3] + v * told.step[i % 3]);
    return shape(places, normalsOf(places, faces), faces);
  };
  const octahedron = () => {
    const corners = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
    const faces = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5];
    return faces.map(k => corners[k]);
  };
  const sphere = () => {  // an octahedron, three times divided
    let corners = octahedron();
    for (let times = 0; times < 3; times++) {
      const finer = [];
      for (let f = 0; f < corners.length; f += 3) {
        const [a, b, c] = corners.slice(f, f + 3);
        const [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(([p, q]) => V3.unit(V3.sum(p, q)));
        finer.push(a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca);
      }
      corners = finer;
    }
    return corners;
  };
  const ownShape = (corners, round) => {
    const places = new Float32Array(corners.flat()), faces = Uint16Array.from(corners, (_, k) => k);
    return shape(places, round ? places : normalsOf(places, faces), faces);
  };
  const links = space.links.map(told => ({link: told.link, shape: mesh(told)}));
  const solids = space.solids.map(told => ({T: new Float32Array(told.T), colour: told.colour, shape: mesh(told)}));
  const ball = ownShape(sphere(), true), diamond = ownShape(octahedron(), false);
  const plates = space.frusta.map(({plate}) => ownShape([0, 1, 2, 0, 2, 3].map(k => plate[k]), false));
  const middle = [0, 1, 2].map(i => space.landmarks.reduce((sum, p) => sum + p[i], 0) / space.landmarks.length);
  const reach = Math.max(...space.landmarks.map(p => Math.hypot(...V3.sum(p, middle, -1)))) * 1.15;
  const wide = 4 * reach;
  const ground = ownShape([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]].map(
    ([x, y]) => [middle[0] + x * wide, middle[1] + y * wide, 0]), false);
  const lines = gl.createBuffer(), lineArray = gl.createVertexArray(), FLOATS = 13;
  gl.bindVertexArray(lineArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, lines);
  [[2, 3, 0], [3, 3, 3], [4, 3, 6], [5, 4, 9]].forEach(([k, count, from]) => {
    gl.enableVertexAttribArray(k);
    gl.vertexAttribPointer(k, count, gl.FLOAT, false, 4 * FLOATS, 4 * from);
  });
  gl.bindVertexArray(null);

  const SIDE = 1600, shadow = gl.createTexture(), shadowIn = gl.createFramebuffer();
  gl.bindTexture(gl.TEXTURE_2D, shadow);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SIDE, SIDE);
  for (const [name, value] of [["TEXTURE_MIN_FILTER", gl.LINEAR], ["TEXTURE_MAG_FILTER", gl.LINEAR],
    ["TEXTURE_COMPARE_MODE", gl.COMPARE_REF_TO_TEXTURE], ["TEXTURE_WRAP_S", gl.CLAMP_TO_EDGE],
    ["TEXTURE_WRAP_T", gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, gl[name], value);
  gl.bindFramebuffer(gl.FRAMEBUFFER, shadowIn);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, shadow, 0);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  const sun = V3.unit([-2, -3, 5]);
  const sunRight = V3.unit(V3.cross([0, 0, 1], sun)), sunUp = V3.cross(sun, sunRight);
  const lit = M4.mul(M4.box(reach, .1, 4 * reach), M4.view(sunRight, sunUp, sun, V3.sum(middle, sun, 2 * reach)));

  // Colours, of the stylesheet's roles
  const linear = c => (c / 255) ** 2.2;
  const role = name => {
    const hex = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    return [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16));
  };
  let colours = {}, look = {};
  const takeColours = () => {
    const dark = document.documentElement.dataset.scheme === "dark";
    look = space.looks[dark ? "dark" : "light"];
    for (const name of ["learner", "demonstrator", "recovered", "residual", "paper"]) colours[name] = role(name);
    for (const name of ["pedestal", "metal", "lens", "plate", "cells", "sections"]) colours[name] = look[name];
    // as on the page: one tint in both schemes, of which each makes its own by its light
    colours.learnerArm = [0, 114, 178].map(c => (c + 255) >> 1);
    colours.demonstratorArm = [230, 159, 0].map(c => (c + 255) >> 1);
  };

  // The camera: azimuth and elevation about a target
  const {fov, margin} = space.view;
  let azimuth, elevation, distance, target, untouched = true;
  const axes = () => {
    const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
    const back = [ce * ca, ce * sa, se], right = [-sa, ca, 0];
    return [right, V3.cross(back, right), back];
  };
  const aspect = () => Math.max(canvas.clientWidth, 1) / Math.max(canvas.clientHeight, 1);
  const fit = () => {  // as near as all landmarks are in sight: opposite sides of the frame bound the eye
    ({azimuth, elevation} = space.view);
    const [right, up, back] = axes(), tan = Math.tan(fov / 2) * margin;
    const place = space.landmarks.map(p => [right, up, back].map(axis => V3.dot(p, axis)));
    const most = f => Math.max(...place.map(f)), found = [];
    for (const [k, slope, below] of [[0, tan * aspect(), tan * aspect()], [1, tan * .86, tan * .94]]) {
      const high = most(p => p[k] + slope * p[2]), low = -most(p => below * p[2] - p[k]);
      found.push({distance: (high - low) / (slope + below), slope, below, high, low});
    }
    const eye = Math.max(found[0].distance, found[1].distance);
    const at = found.map(({slope, below, high, low}) => (high - slope * eye + low + below * eye) / 2);
    const depth = eye - place.reduce((sum, p) => sum + p[2], 0) / place.length;
    const position = right.map((_, i) => at[0] * right[i] + at[1] * up[i] + eye * back[i]);
    distance = depth;
    target = V3.sum(position, back, -depth);
    untouched = true;
  };

  const linkFrames = (arm, angles) => {
    const frames = [new Float32Array(space.bases[arm])];
    space.joints.forEach(({T, axis}, k) => {
      frames.push(M4.mul(M4.mul(frames[k], new Float32Array(T)), M4.turn(axis, angles[k])));
    });
    return frames;
  };
  const spans = [];
  const addLine = (a, b, colour, width, alpha = 1) => {
    for (const [end, side] of [[0, -1], [0, 1], [1, 1], [0, -1], [1, 1], [1, -1]]) {
      const tint = colour.map(c => c / 255);
      spans.push(...a, ...b, end, end ? -side : side, width, ...tint, alpha);
    }
  };
  const draw = (how, what, model, colour, alpha = 1) => {
    gl.uniformMatrix4fv(how.at("model"), false, model);
    if (colour) gl.uniform4f(how.at("colour"), ...colour.map(linear), alpha);
    gl.bindVertexArray(what.made);
    gl.drawElements(gl.TRIANGLES, what.count, what.type, 0);
  };
  const drawSolids = (how, frames) => {
    for (const [arm, placed] of Object.entries(frames))
      for (const {link, shape: what} of links) draw(how, what, placed[link], colours[`${arm}Arm`]);
    for (const {T, colour, shape: what} of solids) draw(how, what, T, colours[colour]);
  };

  const labels = space.labels.map(({text, role: of, at}) => {
    const label = labelsIn.appendChild(document.createElement("span"));
    label.textContent = text;
    label.style.color = `var(--${of === "demonstrator" ? "demonstrator-edge" : of})`;
    return {label, at};
  });
  let shown = null, waits = false;
  const resize = () => {
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const [w, h] = [canvas.clientWidth, canvas.clientHeight].map(px => Math.max(1, Math.round(px * ratio)));
    if (canvas.width === w && canvas.height === h) return;
    [canvas.width, canvas.height] = [w, h];
    if (untouched) fit();
  };
  const paint = () => {
    waits = false;
    if (!shown) return;
    resize();
    const {learner, demonstrator, moment, rays} = shown, size = space.size;
    const frames = {learner: linkFrames("learner", learner), demonstrator: linkFrames("demonstrator", demonstrator)};
    const own = space.points.local.map((p, i) => M4.apply(frames.learner[space.points.link[i]], p));
    const demo = space.points.local.map((p, i) => M4.apply(frames.demonstrator[space.points.link[i]], p));
    const [right, up, back] = axes(), eye = V3.sum(target, back, distance);
    const seen = M4.mul(M4.perspective(fov, aspect(), .02 * size, 60 * size), M4.view(right, up, back, eye));

    gl.enable(gl.DEPTH_TEST);
    gl.disable(gl.BLEND);
    gl.bindFramebuffer(gl.FRAMEBUFFER, shadowIn);
    gl.viewport(0, 0, SIDE, SIDE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(flat.made);
    gl.uniformMatrix4fv(flat.at("seen"), false, lit);
    drawSolids(flat, frames);

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...colours.paper.map(c => c / 255), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.bindTexture(gl.TEXTURE_2D, shadow);
    for (const how of [floor, solid, flat]) {
      gl.useProgram(how.made);
      gl.uniformMatrix4fv(how.at("seen"), false, seen);
      gl.uniformMatrix4fv(how.at("lit"), false, lit);
    }
    gl.useProgram(floor.made);
    for (const name of ["paper", "cells", "sections"])
      gl.uniform3f(floor.at(name), ...colours[name].map(c => c / 255));
    gl.uniform4f(floor.at("around"), middle[0], middle[1], wide * .8, size);
    draw(floor, ground, M4.one());
    gl.useProgram(solid.made);
    gl.uniform3f(solid.at("sun"), ...sun);
    gl.uniform2f(solid.at("power"), look.sky, look.sun);
    drawSolids(solid, frames);
    own.forEach(p => draw(solid, ball, M4.at(p, space.points.learner / 2 * size), colours.learner));
    demo.forEach(p => draw(solid, diamond, M4.at(p, space.points.demonstrator / 2 * size), colours.demonstrator));

    spans.length = 0;
    space.frusta.forEach(({role: of, edges}) => edges.forEach(([a, b]) => addLine(a, b, colours[of], 1.6)));
    moment.recovered.forEach((p, i) => {
      if (!p) return;
      draw(solid, diamond, M4.at(p, .01 * size), colours.recovered);
      addLine(p, own[i], colours.residual, 3);
    });
    gl.useProgram(flat.made);
    moment.plates.forEach((points, k) => points.forEach((p, i) => {
      const of = k < 2 ? "demonstrator" : "learner";
      if (!p) return;
      draw(flat, ball, M4.at(p, .0045 * size), colours[of]);
      if (rays) addLine(p, (k < 2 ? demo : own)[i], colours[of], 1, .35);
    }));
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    plates.forEach(what => draw(flat, what, M4.one(), colours.plate, .55));
    gl.useProgram(line.made);
    gl.uniformMatrix4fv(line.at("seen"), false, seen);
    const ratio = canvas.width / Math.max(canvas.clientWidth, 1);
    gl.uniform2f(line.at("size"), canvas.width / ratio, canvas.height / ratio);
    gl.bindVertexArray(lineArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, lines);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(spans), gl.DYNAMIC_DRAW);
    gl.drawArrays(gl.TRIANGLES, 0, spans.length / FLOATS);
    gl.depthMask(true);
    gl.bindVertexArray(null);

    for (const {label, at} of labels) {
      const w = seen[3] * at[0] + seen[7] * at[1] + seen[11] * at[2] + seen[15];
      const [x, y] = [0, 1].map(i => (seen[i] * at[0] + seen[4 + i] * at[1] + seen[8 + i] * at[2] + seen[12 + i]) / w);
      label.hidden = w <= 0;
      label.style.transform = `translate(${(x + 1) / 2 * canvas.clientWidth}px,${(1 - y) / 2 * canvas.clientHeight}px)`
        + " translate(-50%,-50%)";
    }
  };
  const later = () => {
    if (waits) return;
    waits = true;
    requestAnimationFrame(paint);
  };

  // Hands: one turns, two pinch and shift; the wheel zooms where it does not scroll
  const hands = new Map();
  const turn = (dx, dy) => {
    azimuth -= .008 * dx;
    elevation = Math.min(1.5, Math.max(-.15, elevation + .008 * dy));
  };
  const shift = (dx, dy) => {
    const [right, up] = axes(), px = 2 * distance * Math.tan(fov / 2) / canvas.clientHeight;
    target = V3.sum(V3.sum(target, right, -dx * px), up, dy * px);
  };
  const zoom = by => { distance = Math.min(30 * space.size, Math.max(.2 * space.size, distance * by)); };
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
    if (hands.size === 2) { zoom(wide / spread()); shift(dx / 2, dy / 2); }
    else if (event.buttons & 2 || event.shiftKey) shift(dx, dy);
    else turn(dx, dy);
    untouched = false;
    later();
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"])
    canvas.addEventListener(name, event => hands.delete(event.pointerId));
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    const scrolls = document.documentElement.scrollHeight > innerHeight + 1;
    if (scrolls && !event.ctrlKey) return;
    event.preventDefault();
    zoom(Math.exp(.0012 * event.deltaY));
    untouched = false;
    later();
  }, {passive: false});
  new ResizeObserver(later).observe(canvas);
  takeColours();
  resize();
  fit();
  return {
    show: what => { shown = what; later(); },
    fit: () => { fit(); later(); },
    recolour: () => { takeColours(); later(); },
  };
}
