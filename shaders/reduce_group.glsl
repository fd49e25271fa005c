// Four sums and a maximum over a work group, written by its first lane. The including kernel declares
// `uint sums[]`: floats are kept as bits, since a maximum's bits need not be a number.
#include "group_fold.glsl"

void write_group_sums(vec4 value, uint largest, uint group) {
  uvec4 sum = floatBitsToUint(group_sum(value));
  largest = group_max(largest);
  if (gl_LocalInvocationIndex != 0u) return;
  for (uint c = 0u; c < 4u; ++c) sums[group * kSumFloats + c] = sum[c];
  sums[group * kSumFloats + 4u] = largest;
}
