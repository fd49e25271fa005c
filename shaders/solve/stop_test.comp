// Ends the steps to come where an error was low enough: no work groups for their indirect dispatches.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

layout(local_size_x = 1) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint last = parameters.step_count - 1u;
  if (uintBitsToFloat(steps[last].max_square_bits) > parameters.stop_square) return;
  for (uint i = 0u; i < parameters.count; ++i) arguments[kArgumentWords * i] = 0u;
}
