#version 450
#extension GL_GOOGLE_include_directive : require
#include "patches.glsl"

layout(quads, equal_spacing, cw) in;
layout(location = 0) in uint corners[];
layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out float out_error;

void main() {
  PlanishPoint point = patch_point(corners[0], gl_TessCoord.xy);
  out_position = point.position;
  out_normal = point.normal;
  out_error = 0.0;
  gl_Position = draw.clip_from_world * vec4(point.position, 1.0);
}
