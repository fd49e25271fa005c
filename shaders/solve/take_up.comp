// Where a solve starts from: the last displacement, or none. Sides 0 and 2 get it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "surface/finite.glsl"
#include "shared.h"
#include "items.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict buffer Side0 { vec4 side0[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Side1 { vec4 side1[]; };
layout(std430, set = 0, binding = 2) restrict buffer Side2 { vec4 side2[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Status { SolveStatus statuses[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint row = item_of_lane();
  if (row >= parameters.count) return;
  row += gl_WorkGroupID.y * parameters.instance_rows;
  vec3 start = vec3(0.0);
  if (parameters.warm != 0u) {
    uint side = statuses[gl_WorkGroupID.y].side;
    if (side == 0u)
      start = side0[row].xyz;
    else if (side == 1u)
      start = side1[row].xyz;
    else
      start = side2[row].xyz;
    // One bad frame must not spoil all that follow.
    if (!(is_finite(start.x) && is_finite(start.y) && is_finite(start.z))) start = vec3(0.0);
  }
  side0[row] = vec4(start, 0.0);
  side2[row] = vec4(start, 0.0);
}
