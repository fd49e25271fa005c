// The surface by planish's own shader code. A patch is a corner of a face.
#include "draw.glsl"

layout(set = kSurfaceSet, binding = kWordsBinding) readonly buffer Words { uint words[]; };
layout(set = kSurfaceSet, binding = kLinksBinding) readonly buffer Links { uvec2 links[]; };
layout(set = kSurfaceSet, binding = kStateBinding) readonly buffer State { vec4 state[]; };
layout(set = kSurfaceSet, binding = kSurfaceGivenBinding) readonly buffer Given { vec4 given[]; };
layout(set = kSurfaceSet, binding = kWeightsBinding) readonly buffer Weights { vec4 weights[]; };
uint planish_words_at(uint i) { return words[i]; }
uvec2 planish_links_at(uint i) { return links[i]; }
vec4 planish_state_at(uint i) { return state[i]; }
vec4 planish_given_at(uint i) { return given[i]; }
vec4 planish_weights_at(uint i) { return weights[i]; }
#include "planish_surface.glsl"

// What all patches agree on that meet there, bit by bit.
vec3 patch_position(uint corner, vec2 uv) {
  PlanishPlace place = planish_owner(planish_corner_place(corner, uv.x, uv.y));
  return planish_evaluate(draw.face_count, place).position;
}

// The same, with the patch's own normal.
PlanishPoint patch_point(uint corner, vec2 uv) {
  PlanishPoint point = planish_evaluate(draw.face_count, planish_corner_place(corner, uv.x, uv.y));
  bool is_border = min(uv.x, uv.y) == 0.0 || max(uv.x, uv.y) == 1.0;
  if (is_border) point.position = patch_position(corner, uv);
  return point;
}
