// Picks the used vertices out of a host's array of points, whatever its layout.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"
#include "items.glsl"

layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) restrict readonly buffer Vertices { uint vertices[]; };
layout(std430, set = 0, binding = 1) restrict readonly buffer Source { float source[]; };
layout(std430, set = 0, binding = 2) restrict writeonly buffer Target { vec4 target[]; };
layout(push_constant) uniform Parameters { VectorParameters parameters; };

void main() {
  uint row = item_of_lane();
  if (row >= parameters.count) return;
  uint place = parameters.source_shift + gl_WorkGroupID.y * parameters.instance_floats +
               vertices[row] * parameters.source_stride;
  target[gl_WorkGroupID.y * parameters.instance_rows + row] =
      vec4(source[place], source[place + 1u], source[place + 2u], 0.0);
}
