/*
Shaders. A point X of a block at rest is drawn at

    X + f (R (X - c) + c + u - X),    R, u the block's rotation and displacement, c its centre, f the factor stated next to the model,

and one that is not there as its centre; all blocks in one call: their poses and colours lie in textures. The bands of the joints are those of the crack map (bands.py): four
corners per side of an interface polygon, of a least width in pixels, dashed where the joint has slid.
*/

const ACROSS = 1536; /* texels in a row of the textures; a whole number of poses */

const COMMON = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D poses;
uniform float factor;
uniform vec3 right, up, towards, target;
uniform vec2 extent;
uniform float deep, lift;
ivec2 texel(int i) { return ivec2(i % ${ACROSS}, i / ${ACROSS}); }
vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.yzw, cross(q.yzw, v) + q.x * v); }
vec3 carried(vec3 x, int block) {
  vec4 u = texelFetch(poses, texel(3 * block), 0);
  vec4 q = texelFetch(poses, texel(3 * block + 1), 0);
  vec3 centre = texelFetch(poses, texel(3 * block + 2), 0).xyz, arm = x - centre;
  return u.w > 0.5 ? centre : x + factor * (turned(q, arm) - arm + u.xyz);
}
vec3 carriedNormal(vec3 n, int block) {
  vec4 q = texelFetch(poses, texel(3 * block + 1), 0);
  return normalize(n + factor * (turned(q, n) - n) + 1e-9);
}
vec4 placed(vec3 x) {
  vec3 d = x - target;
  return vec4(dot(d, right) / extent.x, dot(d, up) / extent.y, -dot(d, towards) / deep - lift, 1.0);
}
vec4 named(int id) { return vec4(float(id & 255), float((id >> 8) & 255), float((id >> 16) & 255), 255.0) / 255.0; }
`;

const FACES = {
  vertex: `${COMMON}
uniform sampler2D paint;
uniform bool picking;
in vec3 point, normal;
in uint block;
flat out vec4 colour;
void main() {
  int b = int(block);
  gl_Position = placed(carried(point, b));
  if (picking) { colour = named(b + 1); return; }
  vec3 n = carriedNormal(normal, b);
  n = vec3(dot(n, right), dot(n, up), dot(n, towards));
  float light = 0.45 + 0.50 * max(0.0, dot(n, normalize(vec3(-0.5, 0.6, 0.9)))) + 0.16 * max(0.0, dot(n, normalize(vec3(0.9, 0.1, 0.5))))
    + 0.12 * max(0.0, n.z);
  colour = vec4(min(vec3(1.0), light * texelFetch(paint, texel(b), 0).rgb), 1.0);
}`,
  fragment: `#version 300 es
precision highp float;
flat in vec4 colour;
out vec4 pixel;
void main() { pixel = colour; }`,
};

const EDGES = {
  vertex: `${COMMON}
in vec3 point;
in uint block;
void main() { gl_Position = placed(carried(point, int(block))); }`,
  fragment: `#version 300 es
precision highp float;
uniform vec4 ink;
out vec4 pixel;
void main() { pixel = ink; }`,
};

/* mode 0: bands between both blocks; 1, 2: plates on the faces of a, of b, of separated joints; 3: one joint, chosen; 4: picking. */
const BANDS = {
  vertex: `${COMMON}
uniform sampler2D marks;
uniform int mode, chosen, firstId;
uniform float width;
in vec3 corner, next, arm, nextArm, normal;
in uvec3 owner;
flat out vec3 first, second;
flat out float pieces;
out float along;
void main() {
  int a = int(owner.x), b = int(owner.y), j = int(owner.z);
  vec4 one = texelFetch(marks, texel(2 * j), 0), two = texelFetch(marks, texel(2 * j + 1), 0);
  bool plate = mode == 1 || mode == 2;
  int parted = int(two.a * 3.0 + 0.5); /* 1: the face of a is dark, 2: that of b */
  bool drawn = mode == 4 || (mode == 3 ? j == chosen : plate ? (parted & mode) != 0 : one.a > 0.5);
  if (!drawn) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  bool far = (gl_VertexID & 1) == 1, onB = (gl_VertexID & 2) == 2;
  vec3 x = far ? next : corner;
  int ridden = mode == 2 ? b : a;
  vec3 n = carriedNormal(normal, ridden), xa = carried(x, a), xb = carried(x, b);
  vec3 out3 = carriedNormal(far ? nextArm : arm, ridden);
  float gap = max(dot(xb - xa, n), width);
  vec3 middle = plate ? (mode == 1 ? xa : xb) : 0.5 * (xa + xb);
  if (plate) gap = 0.7 * width;
  vec3 at = middle + 0.7071 * width * out3 + (onB ? 0.5 : -0.5) * gap * n;
  gl_Position = placed(at);
  float length_ = distance(carried(corner, a), carried(next, a));
  first = one.rgb; second = two.rgb;
  pieces = 2.0 * floor(length_ / (6.0 * width) + 0.5) + 1.0;
  if (plate) { first = second = vec3(0.169); }
  if (mode == 3) { first = second = vec3(0.84, 0.0, 0.45); }
  if (mode == 4) { first = second = named(firstId + j).rgb; }
  along = far ? 1.0 : 0.0;
}`,
  fragment: `#version 300 es
precision highp float;
flat in vec3 first, second;
flat in float pieces;
in float along;
out vec4 pixel;
void main() { pixel = vec4(mod(floor(along * pieces), 2.0) < 0.5 ? first : second, 1.0); }`,
};
