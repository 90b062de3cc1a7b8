/** The programs of the 3-D view, in GLSL. */

export const SOLID_VS = `#version 300 es
in vec3 place; in vec3 normal; uniform mat4 model, seen, lit; out vec3 n; out vec3 at; out vec4 shade;
void main(){ vec4 p = model * vec4(place, 1.); n = mat3(model) * normal; at = p.xyz;
  shade = lit * (p + vec4(normalize(n) * .012, 0.)); gl_Position = seen * p; }`;

const SHADOW = `
uniform highp sampler2DShadow map;
float light(vec4 s){ vec3 p = s.xyz / s.w * .5 + .5; if (any(greaterThan(abs(p - .5), vec3(.5)))) return 1.;
  float sum = 0.; for (int i = -1; i < 2; i++) for (int j = -1; j < 2; j++)
    sum += texture(map, vec3(p.xy + vec2(i, j) / 1600., p.z - .0012)); return sum / 9.; }`;

export const SOLID_FS = `#version 300 es
precision highp float; in vec3 n; in vec3 at; in vec4 shade; uniform vec4 colour; uniform vec3 sun; uniform vec2 power;
${SHADOW} out vec4 drawn;
void main(){ vec3 m = normalize(gl_FrontFacing ? n : -n);
  vec3 sky = mix(vec3(.44, .43, .49), vec3(.91, .90, 1.), .5 * m.z + .5) * power.x;
  float d = max(dot(m, sun), 0.); d *= d > 0. ? light(shade) : 0.;
  drawn = vec4(pow(min(colour.rgb * (sky + d * power.y) / 4., 1.), vec3(1. / 2.2)), 1.) * colour.a; }`;

export const FLAT_FS = `#version 300 es
precision highp float; in vec3 n; in vec3 at; in vec4 shade; uniform vec4 colour; out vec4 drawn;
void main(){ drawn = vec4(pow(colour.rgb, vec3(1. / 2.2)), 1.) * colour.a; }`;

export const FLOOR_FS = `#version 300 es
precision highp float; in vec3 n; in vec3 at; in vec4 shade; uniform vec3 paper, cells, sections; uniform vec4 around;
${SHADOW} out vec4 drawn;
float grid(vec2 p, float wide){ vec2 w = fwidth(p); vec2 g = abs(fract(p - .5) - .5);
  vec2 line = clamp(wide - g / w + .5, 0., 1.) * min(vec2(1.), .35 / w); return max(line.x, line.y); }
void main(){ float far = length(at.xy - around.xy) / around.z;
  vec3 c = mix(paper, cells, grid(at.xy / (.25 * around.w), .35)); c = mix(c, sections, grid(at.xy / around.w, .35));
  c *= 1. - .13 * (1. - light(shade)); c = mix(c, paper, smoothstep(.55, 1., far)); drawn = vec4(c, 1.); }`;

export const LINE_VS = `#version 300 es
in vec3 one, other; in vec3 corner; in vec4 tint; uniform mat4 seen; uniform vec2 size; out vec4 colour;
void main(){ vec4 a = seen * vec4(one, 1.), b = seen * vec4(other, 1.);
  vec2 along = (b.xy / b.w - a.xy / a.w) * size; along /= max(length(along), 1e-6);
  vec4 p = corner.x > .5 ? b : a;
  p.xy += vec2(-along.y, along.x) * corner.y * corner.z / size * p.w; colour = tint; gl_Position = p; }`;

export const LINE_FS = `#version 300 es
precision highp float; in vec4 colour; out vec4 drawn; void main(){ drawn = vec4(colour.rgb, 1.) * colour.a; }`;
