// Conjugate gradients: image = B step, with the partial sums of <step, image>.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "table.glsl"

layout(std430, set = 0, binding = 2) restrict readonly buffer Step { float step[]; };
layout(std430, set = 0, binding = 3) restrict writeonly buffer Image { float image[]; };
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
      uvec2 entry = entries[at.first + k * kChunkRows];
      uint place = 3u * entry.x;
      row_image += uintBitsToFloat(entry.y) * vec3(step[place], step[place + 1u], step[place + 2u]);
    }
    uint row = at.row - parameters.first_row;
    image[3u * row] = row_image.x;
    image[3u * row + 1u] = row_image.y;
    image[3u * row + 2u] = row_image.z;
    uint source = 3u * (at.row - parameters.first_source);
    product += weights[row] * vec3(step[source], step[source + 1u], step[source + 2u]) * row_image;
  }
  write_group_sums(vec4(product, 0.0), 0u, parameters.first_group + gl_WorkGroupID.x);
}
