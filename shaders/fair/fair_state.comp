// The control points of level 1: given points with what the construction put around them.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, uint, owners)
READ(1, vec4, model_points)
READ(2, vec4, result)
WRITE(3, vec4, state);

void main() {
  FOR_ELEMENTS(i)
  state[i] = vec4(model_points_at(owners_at(i)).xyz + parameters.scale * result_at(i).xyz, 0.0);
}
