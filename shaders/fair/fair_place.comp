// The given points in unit coordinates.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, vec4, model_points)
WRITE(1, vec4, given);

void main() {
  vec3 origin = vec3(parameters.x, parameters.y, parameters.z);
  FOR_ELEMENTS(v) given[v] = vec4((model_points_at(v).xyz - origin) / parameters.scale, 0.0);
}
