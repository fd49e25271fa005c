// Adds up a float over all work groups of a round. The including kernel declares partials, together, and
// scalars.
#include "group_fold.glsl"
shared bool has_all;

// True in one lane of the group that is the last to have its part: `value` is then the sum of all, in fixed
// order, and scalars are that lane's to write, as all others have read them.
bool is_total(inout float value) {
  bool is_first = gl_LocalInvocationIndex == 0u;
  float part = group_sum(value);
  if (is_first) {
    partials[parameters.first_partial + gl_WorkGroupID.x] = part;
    memoryBarrierBuffer();
    has_all = atomicAdd(scalars[0].parts, 1u) + 1u == parameters.partial_count;
  }
  barrier();
  if (!has_all) return false;
  memoryBarrierBuffer();
  value = 0.0;
  for (uint i = gl_LocalInvocationIndex; i < parameters.partial_count; i += kGroupLanes)
    value += partials[i];
  value = group_sum(value);
  if (is_first) scalars[0].parts = 0u;
  return is_first;
}
