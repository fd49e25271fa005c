// Control points: the given points moved by the displacement that the solve ended with.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "items.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Side0 { vec4 side0[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Side1 { vec4 side1[]; };
layout(std430, set = 0, binding = 2) restrict readonly buffer Side2 { vec4 side2[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Status { SolveStatus statuses[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 5) restrict writeonly buffer Control { vec4 control[]; };
layout(std430, set = 0, binding = 6) restrict writeonly buffer Moved { vec4 moved[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint row = item_of_lane();
  if (row >= parameters.count) return;
  row += gl_WorkGroupID.y * parameters.instance_rows;
  uint side = statuses[gl_WorkGroupID.y].side;
  vec4 displacement = side2[row];
  if (side == 0u) displacement = side0[row];
  if (side == 1u) displacement = side1[row];
  moved[row] = displacement;
  control[row] = given[row] + displacement;
}
