// The points of level 1 at the vertices that an edit has reached, but those of large faces.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "edit.glsl"
#include "read.glsl"

READ(0, uint, places)
READ(1, uint, words)
READ(2, uvec2, links)
READ(3, uint, vertices)
READ(4, vec4, given)
READ(5, vec4, moved)
WRITE(6, vec4, state);
layout(std430, set = 0, binding = 7) restrict readonly buffer Work { uint work[]; };

#include "evaluate/step_points.glsl"

void main() {
  uint count = work[kEditRows];
  for (uint i = gl_GlobalInvocationID.x; i < count; i += lane_count()) {
    uint place = work[parameters.first_listed + i];
    uint instance = place / parameters.row_stride;
    first_row = instance * parameters.row_stride;
    first_point = instance * parameters.point_stride;
    uint end = places_at(place - first_row + 1u);
    for (uint k = places_at(place - first_row); k < end; ++k) {
      uint point = places_at(k);
      if (point < parameters.first_sharp)
        step_corner(point);
      else
        step_sharp(point, parameters.first_word + 2u * (point - parameters.first_sharp));
    }
  }
}
