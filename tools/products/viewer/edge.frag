#version 450
// Cage edges: one dark blue.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(location = 0) out vec4 colour;

void main() { colour = vec4(0.10, 0.28, 0.52, draw.alpha); }
