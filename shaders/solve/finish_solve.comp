// Says where the steps ended: how many were taken, why, at what error, and in which buffer.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "surface/finite.glsl"
#include "shared.h"

layout(local_size_x = 1) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Status { SolveStatus statuses[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint instance = gl_WorkGroupID.y;
  uint instances = parameters.further_instances + 1u;
  uint state = kStateRunning;
  uint largest = 0u;
  uint step = 0u;
  for (; step < parameters.count; ++step) {
    largest = steps[step * instances + instance].max_square_bits;
    if (uintBitsToFloat(largest) <= parameters.stop_square) {
      state = kStateConverged;
      break;
    }
  }
  float square = uintBitsToFloat(largest);
  if (!is_finite(square)) state = kStateNotFinite;
  step = min(step, parameters.step_count);
  statuses[instance].iterations = step;
  statuses[instance].state = state;
  statuses[instance].residual = sqrt(square);
  statuses[instance].max_square_bits = largest;
  if (parameters.keeps_side == 0u)
    statuses[instance].side = (parameters.first_side + step) % 3u;
}
