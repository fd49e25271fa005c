// Limit points and unit normals of the instances that a level's list names, one after another.
#version 450
#extension GL_GOOGLE_include_directive : require
#define PLANISH_STAGES
#define PLANISH_ATTRIBUTES_IN_TARGET
#include "evaluate/corner_patch.glsl"

layout(std430, set = 0, binding = 7) restrict readonly buffer Work { uint work[]; };

void main() {
  begin_instance(work[parameters.segment + gl_WorkGroupID.y], gl_WorkGroupID.y);
  evaluate_units();
}
