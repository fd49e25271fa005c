// The sums that a large ring or face goes by, over the kRingLanes lanes of a work group: each gets them. In
// halves, so always in the same order; a barrier must stand before the next call.
shared vec3 means[kRingLanes], evens[kRingLanes], odds[kRingLanes];

void fold_ring(inout vec3 mean, inout vec3 even, inout vec3 odd) {
  uint lane = gl_LocalInvocationIndex;
  means[lane] = mean, evens[lane] = even, odds[lane] = odd;
  for (uint half_count = kRingLanes / 2u; half_count > 0u; half_count /= 2u) {
    barrier();
    if (lane < half_count) {
      means[lane] += means[lane + half_count];
      evens[lane] += evens[lane + half_count];
      odds[lane] += odds[lane + half_count];
    }
  }
  barrier();
  mean = means[0], even = evens[0], odd = odds[0];
}
