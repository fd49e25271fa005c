// What the lanes of a work group of kGroupLanes have, put together: each gets the result. In halves, so always
// in the same order. All lanes of the group must call.
#ifndef PLANISH_GROUP_FOLD
#define PLANISH_GROUP_FOLD
const uint kGroupLanes = 64u;
shared vec4 lane_values[kGroupLanes];
shared uint lane_words[kGroupLanes];

#define GROUP_FOLD(Type, name, values, part, fold)                                         \
  Type name(Type value) {                                                                  \
    uint lane = gl_LocalInvocationIndex;                                                   \
    barrier(); /* the last result has been read */                                         \
    values[lane] part = value;                                                             \
    for (uint half_count = kGroupLanes / 2u; half_count > 0u; half_count /= 2u) {          \
      barrier();                                                                           \
      if (lane < half_count)                                                               \
        values[lane] part = fold(values[lane] part, values[lane + half_count] part);       \
    }                                                                                      \
    barrier();                                                                             \
    return values[0] part;                                                                 \
  }
#define FOLD_SUM(a, b) ((a) + (b))
#define FOLD_LEAST(a, b) ((b).w < (a).w ? (b) : (a))
GROUP_FOLD(float, group_sum, lane_values, .x, FOLD_SUM)
GROUP_FOLD(vec2, group_sum, lane_values, .xy, FOLD_SUM)
GROUP_FOLD(vec3, group_sum, lane_values, .xyz, FOLD_SUM)
GROUP_FOLD(vec4, group_sum, lane_values, , FOLD_SUM)
GROUP_FOLD(float, group_min, lane_values, .x, min)
GROUP_FOLD(float, group_max, lane_values, .x, max)
GROUP_FOLD(uint, group_max, lane_words, , max)
GROUP_FOLD(vec4, group_least, lane_values, , FOLD_LEAST)

// The sum of what the lanes before this one have.
vec2 sum_before(vec2 value) {
  barrier();
  lane_values[gl_LocalInvocationIndex].xy = value;
  barrier();
  vec2 sum = vec2(0.0);
  for (uint i = 0u; i < gl_LocalInvocationIndex; ++i) sum += lane_values[i].xy;
  return sum;
}
#endif
