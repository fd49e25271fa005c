// Walks around a vertex, a face or a sector. Where these are small each has a lane, that walks alone;
// those of kLargeRing corners and more have a work group, each of whose lanes walks a piece, and what the
// lanes found is put together in always the same order. A kernel is compiled for either; whatever it
// branches by between two walks must be the same in all lanes of a group.
#ifndef PLANISH_FAIR_WALK
#define PLANISH_FAIR_WALK
#include "group_fold.glsl"

// Whether this lane walks around an element with so many corners.
bool is_walked(uint count) { return kShared || count < kLargeRing; }
// The i-th element of this dispatch: records of large ones are listed in the others' words.
#define ELEMENT(records, i) (kShared ? records(i).large : (i))

uint walk_begin(uint count) {
  uint piece = (count + kGroupLanes - 1u) / kGroupLanes;
  return kShared ? min(gl_LocalInvocationIndex * piece, count) : 0u;
}
uint walk_end(uint count) {
  uint piece = (count + kGroupLanes - 1u) / kGroupLanes;
  return kShared ? min((gl_LocalInvocationIndex + 1u) * piece, count) : count;
}
// The lane's own of the numbers first, ..., first + count - 1: the same ones in every walk, so that a lane
// may read what it wrote in an earlier one.
#define FOR_RING(i, first, count)                                                            \
  for (uint i = (first) + walk_begin(count), i##_end = (first) + walk_end(count); i < i##_end; ++i)

// Of a group the lane that writes what the group found.
bool leads() { return !kShared || gl_LocalInvocationIndex == 0u; }
// What lanes wrote to a coherent buffer is for all of the group to read from here on, and what all read is
// for one to write.
void ring_sync() {
  if (!kShared) return;
  memoryBarrierBuffer();
  barrier();
}

float ring_sum(float value) { return kShared ? group_sum(value) : value; }
vec2 ring_sum(vec2 value) { return kShared ? group_sum(value) : value; }
vec3 ring_sum(vec3 value) { return kShared ? group_sum(value) : value; }
float ring_min(float value) { return kShared ? group_min(value) : value; }
float ring_max(float value) { return kShared ? group_max(value) : value; }
bool ring_any(bool value) { return kShared ? group_max(value ? 1.0 : 0.0) > 0.0 : value; }
// The vector with the least w.
vec4 ring_least(vec4 value) { return kShared ? group_least(value) : value; }
// The sum of what the lanes before this one have.
vec2 ring_before(vec2 value) { return kShared ? sum_before(value) : vec2(0.0); }
#endif
