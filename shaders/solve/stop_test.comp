// Ends the steps to come where every instance's error was low enough: no work groups for their
// indirect dispatches.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

shared uint is_above;

void main() {
  uint lane = gl_LocalInvocationIndex;
  if (lane == 0u) is_above = 0u;
  barrier();
  uint instances = parameters.further_instances + 1u;
  uint first = (parameters.step_count - 1u) * instances;
  for (uint i = lane; i < instances; i += kReduceLanes)
    if (uintBitsToFloat(steps[first + i].max_square_bits) > parameters.stop_square)
      atomicOr(is_above, 1u);
  barrier();
  if (lane != 0u || is_above != 0u) return;
  for (uint i = 0u; i < parameters.count; ++i) arguments[kArgumentWords * i] = 0u;
}
