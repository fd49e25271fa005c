// Lists the patches around the vertices that an edit has reached, and those that are stale in its
// slot; forgets that, and says to the other slots what it has reached.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"
#include "read.glsl"

READ(0, uint, jobs)
layout(std430, set = 0, binding = 1) restrict buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 2) buffer Work { uint work[]; };
layout(std430, set = 0, binding = 3) buffer Stale { uint stale[]; };

// `segment`: where the search begins, since a vertex's jobs ascend.
uint segment_of(uint job, uint segment) {
  while (job >= work[segment + kSegmentEnd]) segment += kSegmentWords;
  return segment;
}

// A row that is no longer in the edit's list; the other slots get it, but those that have it.
void forget(uint place, bool is_moved) {
  uint known = flags[place] & ~kRowListed;
  for (uint slot = 0u; is_moved && slot < parameters.slot_count; ++slot) {
    uint bit = 1u << (kStaleShift + slot);
    if (slot == parameters.slot || (known & bit) != 0u) continue;
    known |= bit;
    uint head = stale_head(slot);
    uint at = atomicAdd(stale[head], 1u);
    stale[stale_list(slot) + at] = place;
    atomicMax(stale[head + kStaleArguments], groups_of(at + 1u));
  }
  flags[place] = known;
}

void main() {
  uint count = work[kEditRows];
  // The slot's own stale rows stand behind those that the edit has moved.
  uint moved_count = work[kEditHeld];
  if (gl_GlobalInvocationID.x == 0u) {
    uint head = stale_head(parameters.slot);
    stale[head] = 0u;
    stale[head + kStaleArguments] = 0u;
  }
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = work[parameters.first_listed + i];
    forget(place, i < moved_count);
    uint instance = place / parameters.row_stride;
    uint row = place - instance * parameters.row_stride;
    uint end = jobs_at(row + 1u);
    uint begin = jobs_at(row);
    atomicAdd(work[kEditPatches], end - begin);
    uint segment = kEditHeadWords;
    for (uint k = begin; k < end; ++k) {
      uint job = jobs_at(k);
      segment = segment_of(job, segment);
      uint at = atomicAdd(work[segment], 1u);
      work[work[segment + kSegmentList] + at] = job + instance * parameters.job_count;
      atomicMax(work[segment + kSegmentArguments],
                groups_of((at + 1u) * work[segment + kSegmentChunks]));
    }
  }
}
