#version 450
// Summed: how many layers of the surface face the eye, how many turn away.
layout(location = 0) out vec4 colour;

void main() {
  const float layer = 16.0 / 255.0;  // so that one of a pixel's samples is seen
  colour = gl_FrontFacing ? vec4(layer, 0.0, 0.0, 0.0) : vec4(0.0, layer, 0.0, 0.0);
}
