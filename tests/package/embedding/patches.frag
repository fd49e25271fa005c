#version 450
layout(location = 0) in vec3 normal;
layout(location = 0) out vec4 colour;

void main() {
  float light = 0.2 + 0.8 * max(dot(normalize(normal), normalize(vec3(0.4, 0.5, -0.8))), 0.0);
  colour = vec4(vec3(light), 1.0);
}
