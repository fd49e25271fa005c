#version 450
#extension GL_GOOGLE_include_directive : require
#include "patches.glsl"
// README begins
layout(quads, equal_spacing, cw) in;
layout(location = 0) in uint corners[];
layout(location = 0) out vec3 out_normal;

void main() {
  PlanishPlace place = planish_corner_place(corners[0], gl_TessCoord.x, gl_TessCoord.y);
  out_normal = planish_evaluate(face_count, place).normal;
  gl_Position = clip_from_world * vec4(position_at(corners[0], gl_TessCoord.xy), 1.0);
}
// README ends
