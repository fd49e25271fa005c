// Takes the step of the rows that were measured, unless they are good enough, and lists the rows that
// it reaches: of the vertices of their faces.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"
#include "read.glsl"

READ(0, uint, places)
READ(1, uvec2, links)
READ(2, uint, vertices)
layout(std430, set = 0, binding = 3) restrict buffer Moved { vec4 moved[]; };
layout(std430, set = 0, binding = 4) buffer Velocity { vec4 velocity[]; };
layout(std430, set = 0, binding = 5) restrict readonly buffer Steps { StepRecord steps[]; };
layout(std430, set = 0, binding = 6) buffer Flags { uint flags[]; };
layout(std430, set = 0, binding = 7) buffer Work { uint work[]; };

#include "wake.glsl"

void wake_neighbours(uint first, uint row) {
  uint end = places_at(row + 1u);
  for (uint i = places_at(row); i < end; ++i) {
    uint corner = places_at(i);
    uint other = corner;
    if (corner < parameters.first_sharp) other = links_at(corner).y;
    while (other != corner) {
      wake(first + vertices_at(other));
      other = links_at(other).y;
    }
  }
}

void advance(uint i) {
  uint place = work[parameters.first_listed + i];
  uint instance = place / parameters.row_stride;
  uint first = instance * parameters.row_stride;
  if (parameters.step != kNone) {
    uint step = parameters.step * parameters.instances + instance;
    if (uintBitsToFloat(steps[step].max_square_bits) <= parameters.stop_square) return;
    precise vec3 next = moved[place].xyz + velocity[place].xyz;
    moved[place] = vec4(next, 0.0);
  }
  if (i >= work[kEditSpread]) wake_neighbours(first, place - first);
}

void main() {
  uint count = work[kEditHeld];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) advance(i);
}
