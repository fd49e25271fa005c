// Limit position and unit normal du x dv for every row; the normal is zero where it is undefined.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"

POINTS_BINDING(2, source)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Target { float target[]; };
PAIRS_BINDING(4, derivatives)

// |du x dv| below this part of |du||dv| has no direction that rounding has not made.
const float kParallel = 1e-6;

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
      uvec2 entry = entry_at(at.first + k * kChunkRows);
      vec2 slope = derivatives_at(at.first + k * kChunkRows);
      vec3 point = source_at(entry.x);
      position += uintBitsToFloat(entry.y) * point;
      du += slope.x * point;
      dv += slope.y * point;
    }
    // Scaled to unit size first, so that the products neither vanish nor overflow.
    float u = max(max(abs(du.x), abs(du.y)), abs(du.z));
    float v = max(max(abs(dv.x), abs(dv.y)), abs(dv.z));
    vec3 normal = vec3(0.0);
    if (u > 0.0 && v > 0.0) {
      precise vec3 a = du / u;
      precise vec3 b = dv / v;
      precise vec3 c = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
      float size = sqrt(dot(c, c));
      if (size >= kParallel * sqrt(dot(a, a)) * sqrt(dot(b, b))) normal = c / size;
    }
    uint place = (at.row - parameters.first_row) * parameters.target_stride +
                 parameters.first_target;
    target[place] = position.x;
    target[place + 1u] = position.y;
    target[place + 2u] = position.z;
    place += parameters.normal_offset;
    target[place] = normal.x;
    target[place + 1u] = normal.y;
    target[place + 2u] = normal.z;
  }
}
