// given - B given for every row, as the sum of b_ij (given_i - given_j): rounding is relative to the
// differences, and rows need not sum to 1 to the last bit.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"

READ(2, vec4, given)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Residual { vec4 residual[]; };

void main() {
  uint first_source = gl_WorkGroupID.y * parameters.instance_rows;
  uint first_target = first_source - parameters.first_row;
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) return;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) return;
    vec3 own = given_at(first_source + (at.row - parameters.first_source)).xyz;
    precise vec3 sum = vec3(0.0);
    for (uint k = 0u; k < at.width; ++k) {
      uvec2 entry = entries_at(at.first + k * kChunkRows);
      sum += uintBitsToFloat(entry.y) * (own - given_at(first_source + entry.x).xyz);
    }
    residual[first_target + at.row] = vec4(sum, 0.0);
  }
}
