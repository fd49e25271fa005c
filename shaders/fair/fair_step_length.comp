// The length of the step: the residual's square by the curvature along the direction.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, float, partials)
UPDATE(1, FairScalars, scalars);

#include "group_fold.glsl"

void main() {
  float sum = 0.0;
  for (uint i = gl_LocalInvocationIndex; i < parameters.partial_count; i += 64u) sum += partials_at(i);
  float curvature = group_sum(sum);
  if (gl_LocalInvocationIndex != 0u) return;
  if (parameters.start != 0u) {
    scalars[0].step = 1.0;
    return;
  }
  float square = scalars[0].square;
  // No step once it has converged, or where numbers have left single precision.
  float step = square > scalars[0].enough && curvature > 0.0 ? square / curvature : 0.0;
  scalars[0].step = is_finite(step) ? step : 0.0;
}
