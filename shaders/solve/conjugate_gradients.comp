// Conjugate gradients: a step's image, what the step changes, and the next step, with the sums of
// products by which the host weighs them.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "read.glsl"

#ifdef KERNEL_cg_apply
#include "table.glsl"

READ(2, vec4, steps)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Image { vec4 image[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Weights { float weights[]; };
layout(std430, set = 0, binding = 5) restrict writeonly buffer Sums { uint sums[]; };
#else
layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { VectorParameters parameters; };
#endif
#ifdef KERNEL_cg_advance
#include "square_bits.glsl"

layout(std430, set = 0, binding = 0) restrict buffer Displacement { float displacement[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Step { float step[]; };
layout(std430, set = 0, binding = 2) restrict buffer Residual { float residual[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Image { float image[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Weights { float weights[]; };
layout(std430, set = 0, binding = 5) restrict writeonly buffer Sums { uint sums[]; };
#endif
#ifdef KERNEL_reduce_sums
layout(std430, set = 0, binding = 0) restrict readonly buffer Partials { uint partials[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Sums { uint sums[]; };
#endif

#ifndef KERNEL_cg_turn
#include "group_fold.glsl"

// Four sums and a maximum over a work group, written by its first lane. Floats are kept as bits, since
// a maximum's bits need not be a number.
void write_group_sums(vec4 value, uint largest, uint group) {
  uvec4 sum = floatBitsToUint(group_sum(value));
  largest = group_max(largest);
  if (gl_LocalInvocationIndex != 0u) return;
  for (uint c = 0u; c < 4u; ++c) sums[group * kSumFloats + c] = sum[c];
  sums[group * kSumFloats + 4u] = largest;
}
#endif

#ifdef KERNEL_cg_apply
// image = B step, with the partial sums of <step, image>.
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
#endif

#ifdef KERNEL_cg_advance
// displacement += alpha * step, residual -= alpha * image, with the partial sums of
// <residual, residual>, the plain square sum and the largest square.
void main() {
  vec3 alpha = vec3(parameters.x, parameters.y, parameters.z);
  // A layer's last groups may be too many.
  if (group_of_items() * kItemLanes >= parameters.count) return;
  uint row = item_of_lane();
  precise vec4 value = vec4(0.0);
  uint largest = 0u;
  if (row < parameters.count) {
    precise vec3 rest;
    for (uint c = 0u; c < 3u; ++c) {
      uint at = kPointFloats * row + c;
      precise float moved = displacement[at] + alpha[c] * step[at];
      precise float left = residual[at] - alpha[c] * image[at];
      displacement[at] = moved;
      residual[at] = left;
      rest[c] = left;
    }
    precise float square = rest.x * rest.x + rest.y * rest.y + rest.z * rest.z;
    value = vec4(weights[row] * rest * rest, square);
    largest = square_bits(square);
  }
  write_group_sums(value, largest, group_of_items());
}
#endif

#ifdef KERNEL_cg_turn
// step = residual + beta * step.
layout(std430, set = 0, binding = 0) restrict buffer Step { float step[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Residual { float residual[]; };

void main() {
  vec3 beta = vec3(parameters.x, parameters.y, parameters.z);
  uint row = item_of_lane();
  if (row >= parameters.count) return;
  for (uint c = 0u; c < 3u; ++c) {
    uint at = kPointFloats * row + c;
    precise float turned = residual[at] + beta[c] * step[at];
    step[at] = turned;
  }
}
#endif

#ifdef KERNEL_reduce_sums
// Reduces the groups' partial sums to one, with a single work group.
void main() {
  precise vec4 sum = vec4(0.0);
  uint largest = 0u;
  for (uint i = gl_LocalInvocationIndex; i < parameters.count; i += kReduceLanes) {
    uint at = i * kSumFloats;
    sum += uintBitsToFloat(uvec4(partials[at], partials[at + 1u], partials[at + 2u],
                                 partials[at + 3u]));
    largest = max(largest, partials[at + 4u]);
  }
  write_group_sums(sum, largest, 0u);
}
#endif
