// A surface under a key light, a fill light from the other side and a room that is brighter above.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec4 colour;

vec3 linear(vec3 srgb) { return pow(srgb, vec3(2.2)); }

vec3 to_eye() { return normalize(draw.eye - position); }

// Of the side that is seen.
vec3 seen_normal() {
  vec3 n = normalize(normal);
  return gl_FrontFacing ? n : -n;
}

vec3 light_on(vec3 n) {
  vec3 fill = normalize(vec3(-draw.key.x, 0.25, -draw.key.z) + to_eye());
  vec3 room = mix(vec3(0.10, 0.09, 0.09), vec3(0.24, 0.27, 0.32), 0.5 + 0.5 * n.y);
  return room + vec3(0.86, 0.82, 0.75) * max(dot(n, draw.key), 0.0) +
         vec3(0.13, 0.16, 0.20) * max(dot(n, fill), 0.0);
}

// What is of that linear colour, with a satin coat.
vec4 satin(vec3 base) {
  vec3 n = seen_normal();
  float shine = 0.22 * pow(max(dot(n, normalize(draw.key + to_eye())), 0.0), 48.0);
  float rim = 0.14 * pow(1.0 - max(dot(n, to_eye()), 0.0), 4.0);
  return vec4(displayed(base * light_on(n) + vec3(shine + rim)), 1.0);
}
