// Limit points and unit normals of corner patches, a group after the other.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "corner_patch.glsl"

layout(constant_id = 1) const uint kUnitsPerGroup = 1u;

void main() {
  uint lane = gl_LocalInvocationIndex;
  begin_instance(gl_WorkGroupID.y);
  for (uint i = 0u; i < kUnitsPerGroup; ++i) {
    uint unit = gl_WorkGroupID.x * kUnitsPerGroup + i;
    if (unit >= parameters.unit_count) return;
    PatchGroup group = group_of(parameters.first_group + unit / parameters.chunk_count);
    if (lane >= group.lane_count) continue;
    evaluate_patch(group, lane, unit % parameters.chunk_count);
  }
}
