#version 450
layout(location = 0) in vec3 position;
layout(location = 0) out vec3 control_point;

void main() { control_point = position; }
