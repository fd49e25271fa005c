// Sums of large rings behind the state of level 1, a work group a ring; see patches/patch_mesh.h,
// whose twin this is. Like the other points they are offsets from a given vertex.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { RingSumParameters parameters; };

READ(0, uint, words)
READ(1, vec4, state)
READ(2, vec4, given)
WRITE(3, vec4, sums);
layout(std430, set = 0, binding = 4) restrict readonly buffer Listed { uint listed[]; };

#include "ring_fold.glsl"

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
