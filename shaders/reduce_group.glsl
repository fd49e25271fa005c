// Four sums and a maximum over a work group of 64, written by its first lane. The including kernel
// declares `uint sums[]`: floats are kept as bits, since a maximum's bits need not be a number.
shared vec4 group_sums[kChunkRows];
shared uint group_maxima[kChunkRows];

void write_group_sums(vec4 value, uint largest, uint group) {
  uint lane = gl_LocalInvocationIndex;
  group_sums[lane] = value;
  group_maxima[lane] = largest;
  barrier();
  if (lane != 0u) return;
  precise vec4 sum = value;
  for (uint i = 1u; i < kChunkRows; ++i) {
    sum += group_sums[i];
    largest = max(largest, group_maxima[i]);
  }
  for (uint c = 0u; c < 4u; ++c) sums[group * kSumFloats + c] = floatBitsToUint(sum[c]);
  sums[group * kSumFloats + 4u] = largest;
}
