// Adds up the partial square sums of each step, one work group a step.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "group_fold.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Partials { float partials[]; };
layout(std430, set = 0, binding = 1) restrict buffer Steps { StepRecord steps[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint step = gl_WorkGroupID.x;
  if (step > 0u && uintBitsToFloat(steps[step - 1u].max_square_bits) <= parameters.stop_square)
    return;
  uint first = step * parameters.count;
  precise float sum = 0.0;
  for (uint i = gl_LocalInvocationIndex; i < parameters.count; i += kReduceLanes)
    sum += partials[first + i];
  sum = group_sum(sum);
  if (gl_LocalInvocationIndex == 0u) steps[step].square_sum = sum;
}
