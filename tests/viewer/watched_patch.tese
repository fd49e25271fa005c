#version 450
// patch.tese, whose vertices are captured.
#extension GL_GOOGLE_include_directive : require
#include "patches.glsl"

layout(quads, equal_spacing, cw) in;
layout(location = 0) in uint corners[];
layout(xfb_buffer = 0, xfb_stride = 24) out;
layout(location = 0, xfb_buffer = 0, xfb_offset = 0) out vec3 out_place;
layout(location = 1, xfb_buffer = 0, xfb_offset = 12) out vec3 out_position;

void main() {
  out_place = vec3(float(corners[0]), gl_TessCoord.xy);
  out_position = patch_point(corners[0], gl_TessCoord.xy).position;
  gl_Position = draw.clip_from_world * vec4(out_position, 1.0);
}
