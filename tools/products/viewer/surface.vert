#version 450
// The surface, straight from what record_evaluate wrote.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float error;
layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out float out_error;

void main() {
  out_position = position;
  out_normal = normal;
  out_error = error;
  gl_Position = draw.clip_from_world * vec4(position, 1.0);
}
