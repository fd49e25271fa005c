#version 450
// The given points as discs of some pixels' width, six vertices each.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(set = 0, binding = kGivenBinding) readonly buffer Given { float given[]; };
layout(set = 0, binding = kUsedBinding) readonly buffer Used { uint used[]; };
layout(location = 0) out vec2 place;  // the disc is where its length is at most 1

void main() {
  const vec2 corners[6] = {vec2(-1, -1), vec2(1, -1), vec2(1, 1),
                           vec2(-1, -1), vec2(1, 1),  vec2(-1, 1)};
  place = corners[gl_VertexIndex];
  uint first = 3u * used[gl_InstanceIndex];
  vec3 at = vec3(given[first], given[first + 1u], given[first + 2u]);
  // A little towards the eye: half of each disc would be inside the surface.
  at += 4e-3 * draw.diagonal * normalize(draw.eye - at);
  vec4 centre = draw.clip_from_world * vec4(at, 1.0);
  gl_Position = centre + vec4(place * draw.width / draw.viewport * centre.w, 0.0, 0.0);
}
