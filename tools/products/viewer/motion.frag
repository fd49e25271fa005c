#version 450
// Where a pixel's piece of surface came from, as temporal anti-aliasing wants it, and which it is.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(location = 3) in vec2 uv;
layout(location = 4) in vec4 now;
layout(location = 5) in vec4 before;
layout(location = 0) out vec4 motion;  // pixels since the frame before, texture coordinates

void main() {
  motion = vec4(0.5 * draw.viewport * (now.xy / now.w - before.xy / before.w), uv);
}
