// Conjugate gradients: step = residual + beta * step.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "items.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict buffer Step { float step[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Residual { float residual[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  vec3 beta = vec3(parameters.x, parameters.y, parameters.z);
  uint row = item_of_lane();
  if (row >= parameters.count) return;
  for (uint c = 0u; c < 3u; ++c) {
    uint at = kPointFloats * row + c;
    precise float turned = residual[at] + beta[c] * step[at];
    step[at] = turned;
  }
}
