// What stands before the steps and behind them: given points, the displacement to go on from, the
// residual at none, and the control points.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "surface/finite.glsl"
#include "shared.h"
#include "read.glsl"

#ifdef KERNEL_initial_residual
#include "table.glsl"
#else
layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { VectorParameters parameters; };
#endif

#ifdef KERNEL_gather_points
// Picks the used vertices out of a host's array of points, whatever its layout.
layout(std430, set = 0, binding = 0) restrict readonly buffer Vertices { uint vertices[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Source { float source[]; };
layout(std430, set = 0, binding = 2) restrict writeonly buffer Target { vec4 target[]; };

void main() {
  uint row = item_of_lane();
  if (row >= parameters.count) return;
  uint place = parameters.source_shift + gl_WorkGroupID.y * parameters.instance_floats +
               vertices[row] * parameters.source_stride;
  target[gl_WorkGroupID.y * parameters.instance_rows + row] =
      vec4(source[place], source[place + 1u], source[place + 2u], 0.0);
}
#endif

#ifdef KERNEL_take_up
// Where a solve starts from: the last displacement, or none. Sides 0 and 2 get it.
layout(std430, set = 0, binding = 0) restrict buffer Side0 { vec4 side0[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Side1 { vec4 side1[]; };
layout(std430, set = 0, binding = 2) restrict buffer Side2 { vec4 side2[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Status { SolveStatus statuses[]; };

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
#endif

#ifdef KERNEL_initial_residual
// given - B given for every row, as the sum of b_ij (given_i - given_j): rounding is relative to the
// differences, and rows need not sum to 1 to the last bit.
READ(2, vec4, given)
layout(std430, set = 0, binding = 3) restrict writeonly buffer Residual { vec4 residual[]; };

void main() {
  uint first_source = gl_WorkGroupID.y * parameters.instance_rows;
  uint first_target = first_source - parameters.first_row;
  for (uint i = 0u; i < kChunksPerGroup; ++i) {
    uint chunk = gl_WorkGroupID.x * kChunksPerGroup + i;
    if (chunk >= parameters.chunk_count) return;
    ChunkRow at = chunk_row(chunk);
    if (at.row == kNoRow) return;
    vec3 own = given_at(first_source + (at.row - parameters.first_source)).xyz;
    precise vec3 sum = vec3(0.0);
    for (uint k = 0u; k < at.width; ++k) {
      uvec2 entry = entries_at(at.first + k * kChunkRows);
      sum += uintBitsToFloat(entry.y) * (own - given_at(first_source + entry.x).xyz);
    }
    residual[first_target + at.row] = vec4(sum, 0.0);
  }
}
#endif

#ifdef KERNEL_control_points
// Control points: the given points moved by the displacement that the solve ended with.
layout(std430, set = 0, binding = 0) restrict readonly buffer Side0 { vec4 side0[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Side1 { vec4 side1[]; };
layout(std430, set = 0, binding = 2) restrict readonly buffer Side2 { vec4 side2[]; };
layout(std430, set = 0, binding = 3) restrict readonly buffer Status { SolveStatus statuses[]; };
layout(std430, set = 0, binding = 4) restrict readonly buffer Given { vec4 given[]; };
layout(std430, set = 0, binding = 5) restrict writeonly buffer Control { vec4 control[]; };
layout(std430, set = 0, binding = 6) restrict writeonly buffer Moved { vec4 moved[]; };

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
#endif
