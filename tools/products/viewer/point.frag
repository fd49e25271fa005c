#version 450
// Given points: red discs with a light rim.
layout(location = 0) in vec2 place;
layout(location = 0) out vec4 colour;

void main() {
  float radius = length(place);
  if (radius > 1.0) discard;
  colour = vec4(radius > 0.7 ? vec3(0.98, 0.95, 0.92) : vec3(0.82, 0.20, 0.10), 1.0);
}
