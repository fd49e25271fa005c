// Lists the patches around the vertices that an edit has reached, and forgets that it has.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"
#include "read.glsl"

READ(0, uint, jobs)
WRITE(1, uint, flags);
layout(std430, set = 0, binding = 2) buffer Work { uint work[]; };

// `segment`: where the search begins, since a vertex's jobs ascend.
uint segment_of(uint job, uint segment) {
  while (job >= work[segment + kSegmentEnd]) segment += kSegmentWords;
  return segment;
}

void main() {
  uint count = work[kEditRows];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = work[parameters.first_listed + i];
    flags[place] = 0u;
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
