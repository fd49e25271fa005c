// Puts the rows that are stale in the edit's slot into its list, behind those that it has moved.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"

layout(std430, set = 0, binding = 0) restrict buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 1) restrict buffer Work { uint work[]; };
layout(std430, set = 0, binding = 2) restrict readonly buffer Stale { uint stale[]; };

void main() {
  uint count = stale[stale_head(parameters.slot)];
  uint bit = 1u << (kStaleShift + parameters.slot);
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = stale[stale_list(parameters.slot) + i];
    uint known = flags[place];
    flags[place] = known & ~bit;
    if ((known & kRowListed) != 0u) continue;
    uint at = atomicAdd(work[kEditRows], 1u);
    work[parameters.first_listed + at] = place;
    atomicMax(work[kEditForRows], groups_of(at + 1u));
  }
}
