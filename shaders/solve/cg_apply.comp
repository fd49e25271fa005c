// Conjugate gradients: image = B step, with the partial sums of <step, image>.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"

READ(2, vec4, steps)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Image { vec4 image[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Weights { float weights[]; };
layout(std430, set = 0, binding = 5) restrict writeonly buffer Sums { uint sums[]; };

#include "reduce_group.glsl"

void main() {
  precise vec3 product = vec3(0.0);
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) break;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) continue;
    precise vec3 row_image = vec3(0.0);
    for (uint k = 0u; k < at.width; ++k) {
      uvec2 entry = entries_at(at.first + k * kChunkRows);
      row_image += uintBitsToFloat(entry.y) * steps_at(entry.x).xyz;
    }
    uint row = at.row - parameters.first_row;
    image[row] = vec4(row_image, 0.0);
    product += weights[row] * steps_at(at.row - parameters.first_source).xyz * row_image;
  }
  write_group_sums(vec4(product, 0.0), 0u, parameters.first_group + gl_WorkGroupID.x);
}
