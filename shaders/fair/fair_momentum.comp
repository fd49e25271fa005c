// The part of the last direction in the next one: by how much the residual's square has changed.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, float, partials)
UPDATE(1, FairScalars, scalars);

#include "group_fold.glsl"

// Of the first residual's square: single precision reaches no lower.
const float kConverged = 1e-12;

void main() {
  float sum = 0.0;
  for (uint i = gl_LocalInvocationIndex; i < parameters.partial_count; i += 64u) sum += partials_at(i);
  float square = group_sum(sum);
  if (gl_LocalInvocationIndex != 0u) return;
  if (parameters.start != 0u) {
    scalars[0].step = 0.0;
    scalars[0].momentum = 0.0;
    scalars[0].enough = kConverged * square;
  } else {
    float momentum = scalars[0].square > 0.0 ? square / scalars[0].square : 0.0;
    scalars[0].momentum = is_finite(momentum) ? momentum : 0.0;
  }
  scalars[0].square = square;
}
