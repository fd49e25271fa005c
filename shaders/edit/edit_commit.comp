// What an edit has moved, where solves go on from and hosts look for control points.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"

layout(std430, set = 0, binding = 0) restrict writeonly buffer Side0 { vec4 side0[]; };
layout(std430, set = 0, binding = 1) restrict writeonly buffer Side1 { vec4 side1[]; };
layout(std430, set = 0, binding = 2) restrict writeonly buffer Side2 { vec4 side2[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Status { SolveStatus statuses[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 5) restrict readonly buffer Moved { vec4 moved[]; };
layout(std430, set = 0, binding = 6) restrict writeonly buffer Control { vec4 control[]; };
layout(std430, set = 0, binding = 7) restrict readonly buffer Work { uint work[]; };

void main() {
  uint count = work[kEditRows];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = work[parameters.first_listed + i];
    vec4 displacement = moved[place];
    uint side = statuses[place / parameters.row_stride].side;
    if (side == 0u)
      side0[place] = displacement;
    else if (side == 1u)
      side1[place] = displacement;
    else
      side2[place] = displacement;
    control[place] = given[place] + displacement;
  }
}
