// Adds up a float of every invocation of a work group of 64; the sum is its first lane's.
shared float lane_sums[64];

float group_sum(float value) {
  uint lane = gl_LocalInvocationIndex;
  lane_sums[lane] = value;
  for (uint half_count = 32u; half_count > 0u; half_count /= 2u) {
    barrier();
    if (lane < half_count) lane_sums[lane] += lane_sums[lane + half_count];
  }
  barrier();
  return lane_sums[0];
}
