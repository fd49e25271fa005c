// Takes the moved points from the host's, and lists their rows. What the host names may be anything.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"
#include "surface/finite.glsl"
#include "read.glsl"

layout(std430, set = 0, binding = 0) restrict readonly buffer Moves { uint moves[]; };
READ(1, uint, vertices)
layout(std430, set = 0, binding = 2) restrict readonly buffer Source { float source[]; };
WRITE(3, vec4, given);
WRITE(4, vec4, velocity);
layout(std430, set = 0, binding = 5) buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 6) buffer Work { uint work[]; };

#include "wake.glsl"

// kNone where no face names the vertex. Rows ascend with their vertices.
uint row_of(uint vertex) {
  uint low = 0u, high = min(vertex, parameters.row_count - 1u);
  if (vertices_at(high) == vertex) return high;
  while (low < high) {
    uint middle = (low + high) / 2u;
    if (vertices_at(middle) < vertex)
      low = middle + 1u;
    else
      high = middle;
  }
  return vertices_at(low) == vertex ? low : kNone;
}

void take(uint move) {
  uint instance = move / parameters.given_count;
  if (instance >= parameters.instances) return;
  uint vertex = move - instance * parameters.given_count;
  uint row = row_of(vertex);
  if (row == kNone) return;
  uint place = parameters.source_shift + instance * parameters.instance_floats +
               vertex * parameters.source_stride;
  vec3 point = vec3(source[place], source[place + 1u], source[place + 2u]);
  // One bad point must not spoil all that edits reach.
  if (!(is_finite(point.x) && is_finite(point.y) && is_finite(point.z))) return;
  row += instance * parameters.row_stride;
  given[row] = vec4(point, 0.0);
  if (!wake(row)) return;
  uint held = atomicAdd(work[kEditHeld], 1u);
  atomicMax(work[kEditForHeld], groups_of(held + 1u));
}

void main() {
  uint count = work[kEditMoves];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count())
    take(moves[parameters.moves_shift + 1u + i]);
}
