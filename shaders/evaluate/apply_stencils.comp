// Applies a stencil table: for every row the weighted sum of source elements.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#define PLANISH_PARAMETERS StencilParameters
#include "table.glsl"

READ_OF_WRITTEN(2, float, source)
layout(std430, set = 0, binding = 3) writeonly buffer Target { float target[]; };

#include "elements.glsl"

void apply_row(ChunkRow at, uint first, uint place, uint left) {
  precise vec4 image = vec4(0.0);
  for (uint k = 0u; k < at.width; ++k) {
    uvec2 entry = entries_at(at.first + k * kChunkRows);
    image += uintBitsToFloat(entry.y) * source_piece(first + entry.x * kSourceStride, left);
  }
  write_piece(image, place, left);
}

void main() {
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) return;
    ChunkRow at = chunk_row(parameters.first_chunk + chunk);
    // kNoRow, of lanes without a row, is beyond every end.
    if (at.row < parameters.begin_row || at.row >= parameters.end_row) continue;
    uint place = parameters.first_target + (at.row - parameters.first_row) * kTargetStride;
    for (uint c = 0u; c < kLength; c += 4u)
      apply_row(at, parameters.first_source + c, place + c, kLength - c);
  }
}
