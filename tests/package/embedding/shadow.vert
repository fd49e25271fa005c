#version 450
#extension GL_GOOGLE_include_directive : require
#include "camera.glsl"
layout(location = 0) in vec4 position;
invariant gl_Position;

void main() { gl_Position = clip_from_world * vec4(world(position), 1.0); }
