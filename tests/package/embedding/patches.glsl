// The surface by the package's shader code, at bindings of the application's own.
layout(push_constant) uniform View {
  mat4 clip_from_world;
  uint face_count, corner_count;
  uint is_software;
  float edges;  // of half a view's width
};
// README begins
layout(std430, set = 0, binding = 0) readonly buffer Words { uint words[]; };
layout(std430, set = 0, binding = 1) readonly buffer Links { uvec2 links[]; };
layout(std430, set = 0, binding = 2) readonly buffer State { vec4 state[]; };
layout(std430, set = 0, binding = 3) readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 4) readonly buffer Weights { vec4 weights[]; };
uint planish_words_at(uint i) { return words[i]; }
uvec2 planish_links_at(uint i) { return links[i]; }
vec4 planish_state_at(uint i) { return state[i]; }
vec4 planish_given_at(uint i) { return given[i]; }
vec4 planish_weights_at(uint i) { return weights[i]; }
#include "planish_surface.glsl"

// What all corners that meet there agree on.
vec3 position_at(uint corner, vec2 uv) {
  PlanishPlace place = planish_owner(planish_corner_place(corner, uv.x, uv.y));
  return planish_evaluate(face_count, place).position;
}
// README ends
