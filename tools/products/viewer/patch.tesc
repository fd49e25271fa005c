#version 450
layout(vertices = 1) out;
layout(location = 0) in uint corners[];
layout(location = 1) in vec4 outer[];
layout(location = 2) in vec2 inner[];
layout(location = 0) out uint out_corners[];

void main() {
  out_corners[gl_InvocationID] = corners[0];
  for (int i = 0; i < 4; ++i) gl_TessLevelOuter[i] = outer[0][i];
  for (int i = 0; i < 2; ++i) gl_TessLevelInner[i] = inner[0][i];
}
