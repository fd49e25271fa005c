// The state of level 1 from the cage: its control points, and behind them the sums of large rings. All are
// offsets from the given vertices, sums of differences, which keep their digits wherever the model lies.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;

#ifdef KERNEL_first_step
layout(constant_id = 3) const uint kStep = kStepFaces;
layout(push_constant) uniform Parameters { FirstStepParameters parameters; };

READ(0, uint, words)
READ(1, uvec2, links)
READ(2, uint, vertices)
READ(3, vec4, given)
READ(4, vec4, moved)
WRITE(5, vec4, state);
layout(std430, set = 0, binding = 6) restrict readonly buffer Listed { uint listed[]; };
#endif
#ifdef KERNEL_ring_sums
layout(push_constant) uniform Parameters { RingSumParameters parameters; };

READ(0, uint, words)
READ(1, vec4, state)
READ(2, vec4, given)
WRITE(3, vec4, sums);
layout(std430, set = 0, binding = 4) restrict readonly buffer Listed { uint listed[]; };
#endif

// The sums that a large ring or face goes by, over the kRingLanes lanes of a work group: each gets them. In
// halves, so always in the same order; a barrier must stand before the next call.
shared vec3 means[kRingLanes], evens[kRingLanes], odds[kRingLanes];

void fold_ring(inout vec3 mean, inout vec3 even, inout vec3 odd) {
  uint lane = gl_LocalInvocationIndex;
  means[lane] = mean, evens[lane] = even, odds[lane] = odd;
  for (uint half_count = kRingLanes / 2u; half_count > 0u; half_count /= 2u) {
    barrier();
    if (lane < half_count) {
      means[lane] += means[lane + half_count];
      evens[lane] += evens[lane + half_count];
      odds[lane] += odds[lane + half_count];
    }
  }
  barrier();
  mean = means[0], even = evens[0], odd = odds[0];
}

#ifdef KERNEL_first_step
// Control points of level 1 from those of the cage.
#include "step_points.glsl"

const uint kStepLanes = 64u;

vec2 turn_at(uint place, uint i) {
  return vec2(uintBitsToFloat(words_at(place + 2u * i)),
              uintBitsToFloat(words_at(place + 2u * i + 1u)));
}

// refine_large_face() of patches/doo_sabin_step.cpp.
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
#endif

#ifdef KERNEL_ring_sums
// Sums of large rings, a work group a ring; see patches/patch_mesh.h, whose twin this is.

float float_at(uint i) { return uintBitsToFloat(words_at(i)); }

void sum_ring(uint instance, uint head, uint lane) {
  uint first_point = words_at(head), row_count = words_at(head + 1u), size = words_at(head + 2u);
  uint first_sum = words_at(head + 3u) - parameters.first_target;
  uint owner = words_at(head + 4u), weight = words_at(head + 5u);
  uint turn = weight + 3u * row_count;
  uint first_given = instance * parameters.instance_rows;
  uint first_state = instance * parameters.instance_points;
  vec3 origin = given_at(first_given + owner).xyz;
  precise vec3 mean = vec3(0.0), even = vec3(0.0), odd = vec3(0.0);
  for (uint i = lane; i < row_count; i += kRingLanes) {
    vec4 point = state_at(first_state + words_at(first_point + i));
    uint vertex = floatBitsToUint(point.w) & ~kVertexTag;
    precise vec3 x = (given_at(first_given + vertex).xyz - origin) + point.xyz;
    mean += float_at(weight + 3u * i) * x;
    even += float_at(weight + 3u * i + 1u) * x;
    odd += float_at(weight + 3u * i + 2u) * x;
  }
  fold_ring(mean, even, odd);
  float tag = uintBitsToFloat(owner | kVertexTag);
  for (uint i = lane; i < size; i += kRingLanes) {
    float cosine = float_at(turn + 2u * i), sine = float_at(turn + 2u * i + 1u);
    uint place = first_state + first_sum + 3u * i;
    sums[place] = vec4(mean, tag);
    sums[place + 1u] = vec4(mean + (cosine * even + sine * odd), tag);
    sums[place + 2u] = vec4(mean + (cosine * odd - sine * even), tag);
  }
  // Before the next ring's sums take their places.
  barrier();
}

void main() {
  uint instance = gl_WorkGroupID.y;
  if (parameters.first_listed != kNone) instance = listed[parameters.first_listed + instance];
  for (uint ring = gl_WorkGroupID.x; ring < parameters.count; ring += gl_NumWorkGroups.x)
    sum_ring(instance, ring * kRingWords, gl_LocalInvocationIndex);
}
#endif
