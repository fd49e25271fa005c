// Limit points and unit normals of corner patches, a group after the other.
#version 450
#extension GL_GOOGLE_include_directive : require
#define PLANISH_STAGES
#include "corner_patch.glsl"

void main() {
  begin_instance(gl_WorkGroupID.y, gl_WorkGroupID.y);
  evaluate_units();
}
