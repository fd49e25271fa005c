// Reduces the groups' partial sums of conjugate gradients to one, with a single work group.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Partials { uint partials[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Sums { uint sums[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

#include "reduce_group.glsl"

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
