// Control points of level 1 from those of the cage, as offsets from the given vertices: sums of
// differences between neighbours, which keep their digits wherever the model lies.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"
#include "items.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 3) const uint kStep = kStepFaces;
layout(push_constant) uniform Parameters { FirstStepParameters parameters; };

READ(0, uint, words)
READ(1, uvec2, links)
READ(2, uint, vertices)
READ(3, vec4, given)
READ(4, vec4, moved)
WRITE(5, vec4, state);
layout(std430, set = 0, binding = 6) restrict readonly buffer Listed { uint listed[]; };

#include "ring_fold.glsl"
#include "step_points.glsl"

const uint kStepLanes = 64u;

vec2 turn_at(uint place, uint i) {
  return vec2(uintBitsToFloat(words_at(place + 2u * i)),
              uintBitsToFloat(words_at(place + 2u * i + 1u)));
}

// refine_large_face() of patches/first_step.cpp.
void step_large_face(uint head, uint lane) {
  uint first = words_at(head), size = words_at(head + 1u), turns = words_at(head + 2u);
  vec3 origin = origin_of(vertex_of(first));
  precise vec3 mean = vec3(0.0), even = vec3(0.0), odd = vec3(0.0);
  for (uint i = lane; i < size; i += kStepLanes) {
    vec3 x = from(origin, vertex_of(first + i));
    vec2 turn = turn_at(turns, i);
    mean += x;
    even += turn.x * x;
    odd += turn.y * x;
  }
  fold_ring(mean, even, odd);
  float share = 1.0 / float(size), swing = 2.0 * parameters.turn * share;
  mean *= share, even *= swing, odd *= swing;
  for (uint i = lane; i < size; i += kStepLanes) {
    uint vertex = vertex_of(first + i);
    uint before = vertex_of(first + (i == 0u ? size : i) - 1u);
    uint after = vertex_of(first + (i + 1u == size ? 0u : i + 1u));
    vec3 own = origin_of(vertex);
    vec2 turn = turn_at(turns, i);
    precise vec3 offset = parameters.own * from(own, vertex) +
                          parameters.beside * (from(own, before) + from(own, after)) +
                          parameters.mean * (mean - (own - origin)) +
                          (turn.x * even + turn.y * odd);
    write_point(first + i, vertex, offset);
  }
  // Before the next face's sums take their places.
  barrier();
}

void main() {
  uint instance = gl_WorkGroupID.y;
  if (parameters.first_listed != kNone) instance = listed[parameters.first_listed + instance];
  first_row = instance * parameters.instance_rows;
  first_point = instance * parameters.instance_points;
  if (kStep == kStepLargeFaces) {
    for (uint face = gl_WorkGroupID.x; face < parameters.count; face += gl_NumWorkGroups.x)
      step_large_face(parameters.first_word + kLargeFaceWords * face, gl_LocalInvocationIndex);
    return;
  }
  uint i = item_of_lane();
  if (i >= parameters.count) return;
  if (kStep == kStepSharp)
    step_sharp(parameters.first_point + i, parameters.first_word + 2u * i);
  else
    step_corner(parameters.first_point + i);
}
