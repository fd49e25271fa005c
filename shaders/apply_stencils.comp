// Applies a stencil table: one point of the target for every row.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"

POINTS_BINDING(2, source)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Target { float target[]; };

void main() {
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) return;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) return;
    precise vec3 image = vec3(0.0);
    for (uint k = 0u; k < at.width; ++k) {
      uvec2 entry = entry_at(at.first + k * kChunkRows);
      image += uintBitsToFloat(entry.y) * source_at(entry.x);
    }
    uint place = (at.row - parameters.first_row) * parameters.target_stride +
                 parameters.first_target;
    target[place] = image.x;
    target[place + 1u] = image.y;
    target[place + 2u] = image.z;
  }
}
