// Conjugate gradients: displacement += alpha * step, residual -= alpha * image, with the partial
// sums of <residual, residual>, the plain square sum and the largest square.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "items.glsl"
#include "square_bits.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict buffer Displacement { float displacement[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Step { float step[]; };
layout(std430, set = 0, binding = 2) restrict buffer Residual { float residual[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Image { float image[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Weights { float weights[]; };
layout(std430, set = 0, binding = 5) restrict writeonly buffer Sums { uint sums[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

#include "reduce_group.glsl"

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
