// The control points of level 1: given points with what the construction put around them.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, uint, owners)
READ(1, vec4, model_points)
READ(2, vec4, result)
WRITE(3, vec4, state);
WRITE(4, vec4, offsets);  // the same, as corner patches take them

void main() {
  FOR_ELEMENTS(i) {
    uint vertex = owners_at(i);
    vec3 offset = parameters.scale * result_at(i).xyz;
    state[i] = vec4(model_points_at(vertex).xyz + offset, 0.0);
    offsets[i] = vec4(offset, uintBitsToFloat(vertex | kVertexTag));
  }
}
