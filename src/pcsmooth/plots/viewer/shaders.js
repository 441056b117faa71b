// Programs of the graphics card: round points, lit from their normals, then shadows in hollows.

const POINT_VERTEX = `#version 300 es
precision highp float;
in vec3 before, after;
in vec2 normalBefore, normalAfter;
in float valueBefore, valueAfter;
uniform mat3 axes;
uniform vec3 center, slabNormal, valueAxis, tint;
uniform vec2 halfSize, slab, valueScale;
uniform float share, diameter;
uniform int coloring;
uniform bool isLit;
uniform sampler2D shades;
out vec3 color;

const float FAR = 2.0;

// The normal of a place on half an octahedron; zero if it is unknown.
vec3 normalAt(vec2 numbers) {
  if (numbers.x > 254.5) return vec3(0.0);
  vec2 place = numbers / 127.0 - 1.0;
  vec2 flat_ = 0.5 * vec2(place.x + place.y, place.x - place.y);
  return normalize(vec3(flat_, 1.0 - abs(flat_.x) - abs(flat_.y)));
}

// Brightness of a surface by its normal, as in pictures.
float lit() {
  vec3 first = normalAt(normalBefore), last = normalAt(normalAfter);
  vec3 normal = axes * mix(dot(first, last) < 0.0 ? -first : first, last, share);
  if (dot(normal, normal) < 1e-6) return 0.5;
  normal = normalize(normal.z < 0.0 ? -normal : normal);
  return 0.25 + 0.75 * max(0.0, dot(normal, normalize(vec3(-0.45, 0.55, 0.7))));
}

void main() {
  vec3 place = mix(before, after, share);
  vec3 seen = axes * (place - center);
  gl_Position = vec4(seen.xy / halfSize, -dot(vec3(axes[0].z, axes[1].z, axes[2].z), place) / FAR, 1.0);
  if (abs(dot(slabNormal, place) - slab.x) > slab.y) gl_Position = vec4(0.0, 0.0, 9.0, 1.0);
  gl_PointSize = diameter;
  color = tint;
  if (coloring == 1 || coloring == 2) {
    float value = coloring == 2 ? (dot(valueAxis, place) - valueScale.x) * valueScale.y
      : share == 0.0 ? valueBefore : share == 1.0 ? valueAfter : mix(valueBefore, valueAfter, share);
    bool isKnown = coloring == 2
      || max(share < 1.0 ? valueBefore : 0.0, share > 0.0 ? valueAfter : 0.0) < 65000.0;
    color = isKnown ? texture(shades, vec2(clamp(0.5 + 0.5 * value, 0.002, 0.998), 0.5)).rgb
      : vec3(0.6);
  }
  if (isLit) color *= mix(1.0, lit(), coloring == 0 ? 1.0 : coloring == 3 ? 0.45 : 0.7);
}`;

const POINT_FRAGMENT = `#version 300 es
precision mediump float;
in vec3 color;
out vec4 drawn;
void main() {
  vec2 place = gl_PointCoord - 0.5;
  if (dot(place, place) > 0.25) discard;
  drawn = vec4(color, 1.0);
}`;

const SHADOW_VERTEX = `#version 300 es
void main() {
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}`;

const SHADOW_FRAGMENT = `#version 300 es
precision highp float;
uniform highp sampler2D depths;
uniform sampler2D colors;
uniform ivec4 panel;
uniform vec3 paper;
uniform float pixel, around;
uniform int places; // around a pixel, that tell whether it lies in a hollow
uniform bool isLit;
out vec4 drawn;

const float FAR = 2.0;
const float LOST = 0.6;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float depth = texelFetch(depths, at, 0).r;
  if (depth == 1.0) { drawn = vec4(paper, 1.0); return; }
  float below = 0.0, count = 0.0;
  if (isLit) {
    for (int i = 0; i < places; i++) {
      float angle = 2.39996 * float(i), far = around * sqrt((float(i) + 0.5) / float(places));
      ivec2 there = at + ivec2(round(far * vec2(cos(angle), sin(angle))));
      if (any(lessThan(there, panel.xy)) || any(greaterThanEqual(there, panel.zw))) continue;
      float other = texelFetch(depths, there, 0).r;
      if (other == 1.0) continue;
      below += clamp((depth - other) * 2.0 * FAR / (around * pixel), -1.0, 1.0);
      count += 1.0;
    }
  }
  float light = 1.0 - LOST * clamp(below / max(count, 1.0), 0.0, 1.0);
  drawn = vec4(texelFetch(colors, at, 0).rgb * light, 1.0);
}`;
