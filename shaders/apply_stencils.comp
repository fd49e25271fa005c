// Applies a stencil table: for every row the weighted sum of source elements, each of kLength floats.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#define PLANISH_PARAMETERS StencilParameters
#include "table.glsl"

// Floats of an element, and from one element to the next.
layout(constant_id = 3) const uint kLength = 3u;
layout(constant_id = 4) const uint kSourceStride = kPointFloats;
layout(constant_id = 5) const uint kTargetStride = kPointFloats;

FLOATS_BINDING(2, source)
layout(std430, set = 0, binding = 3) writeonly buffer Target { float target[]; };

// Up to four floats of an element; `left` are those that there are.
vec4 source_piece(uint at, uint left) {
  vec4 piece = vec4(0.0);
  piece.x = source_at(at);
  if (left > 1u) piece.y = source_at(at + 1u);
  if (left > 2u) piece.z = source_at(at + 2u);
  if (left > 3u) piece.w = source_at(at + 3u);
  return piece;
}

void apply_row(ChunkRow at, uint first, uint place, uint left) {
  precise vec4 image = vec4(0.0);
  for (uint k = 0u; k < at.width; ++k) {
    uvec2 entry = entry_at(at.first + k * kChunkRows);
    image += uintBitsToFloat(entry.y) * source_piece(first + entry.x * kSourceStride, left);
  }
  target[place] = image.x;
  if (left > 1u) target[place + 1u] = image.y;
  if (left > 2u) target[place + 2u] = image.z;
  if (left > 3u) target[place + 3u] = image.w;
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
