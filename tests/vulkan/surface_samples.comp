// The surface as a host's own code, at even samples of all corners' squares: the position that all
// corners that meet there have, that of the corner alone, and its normal.
#version 450
#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { uint face_count, corner_count, side; };
// In an order of the host's.
layout(std430, set = 0, binding = 3) readonly buffer Words { uint words[]; };
layout(std430, set = 0, binding = 0) readonly buffer Links { uvec2 links[]; };
layout(std430, set = 0, binding = 5) readonly buffer State { vec4 state[]; };
layout(std430, set = 0, binding = 1) readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 2) readonly buffer Weights { vec4 weights[]; };
layout(std430, set = 0, binding = 4) writeonly buffer Samples { float samples[]; };
uint planish_words_at(uint i) { return words[i]; }
uvec2 planish_links_at(uint i) { return links[i]; }
vec4 planish_state_at(uint i) { return state[i]; }
vec4 planish_given_at(uint i) { return given[i]; }
vec4 planish_weights_at(uint i) { return weights[i]; }
#include "planish_surface.glsl"

void put(uint place, vec3 v) {
  for (int k = 0; k < 3; ++k) samples[place + k] = v[k];
}

void main() {
  uint i = gl_GlobalInvocationID.x, row = side + 1u, corner = i / (row * row), s = i % (row * row);
  if (corner >= planish_corner_count(face_count)) return;
  PlanishPlace place =
      planish_corner_place(corner, float(s % row) / float(side), float(s / row) / float(side));
  put(9u * i, planish_evaluate(face_count, planish_owner(place)).position);
  PlanishPoint own = planish_evaluate(face_count, place);
  put(9u * i + 3u, own.position);
  put(9u * i + 6u, own.normal);
}
