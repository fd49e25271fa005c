// Limit points and unit normals of the corner patches that an edit has listed.
#version 450
#extension GL_GOOGLE_include_directive : require
#define PLANISH_ATTRIBUTES_IN_TARGET
#include "evaluate/corner_patch.glsl"

layout(std430, set = 0, binding = 7) restrict readonly buffer Work { uint work[]; };

void main() {
  uint chunk_count = parameters.chunk_count;
  uint count = work[parameters.segment] * chunk_count;
  uint list = work[parameters.segment + kSegmentList];
  uint lanes = gl_NumWorkGroups.x * kPatchLanes;
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lanes) {
    uint job = work[list + i / chunk_count];
    uint instance = job / parameters.job_count;
    job -= instance * parameters.job_count;
    begin_instance(instance, instance);
    PatchGroup group = group_of(job / kPatchLanes);
    FOR_CHUNKS(group, i % chunk_count)
      evaluate_patch(group, job % kPatchLanes, chunk);
  }
}
