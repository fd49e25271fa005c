// Limit position and unit normal du x dv for every row; the normal is zero where it is undefined.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"

READ(2, vec4, source)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Target { float target[]; };
READ(4, vec2, derivatives)

#include "limit_row.glsl"

void main() {
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) return;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) return;
    precise vec3 position = vec3(0.0);
    precise vec3 du = vec3(0.0);
    precise vec3 dv = vec3(0.0);
    for (uint k = 0u; k < at.width; ++k) {
      uvec2 entry = entries_at(at.first + k * kChunkRows);
      vec2 slope = derivatives_at(at.first + k * kChunkRows);
      vec3 point = source_at(entry.x).xyz;
      position += uintBitsToFloat(entry.y) * point;
      du += slope.x * point;
      dv += slope.y * point;
    }
    uint place = (at.row - parameters.first_row) * parameters.target_stride +
                 parameters.first_target;
    write_vector(place, position);
    write_vector(place + parameters.normal_offset, unit_normal(du, dv));
  }
}
