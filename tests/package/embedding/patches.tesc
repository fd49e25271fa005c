#version 450
layout(vertices = 1) out;
layout(location = 0) in uint corners[];
layout(location = 1) in vec4 levels[];
layout(location = 0) out uint out_corners[];

void main() {
  out_corners[gl_InvocationID] = corners[0];
  for (int i = 0; i < 4; ++i) gl_TessLevelOuter[i] = levels[0][i];
  gl_TessLevelInner[0] = max(levels[0][1], levels[0][3]);
  gl_TessLevelInner[1] = max(levels[0][0], levels[0][2]);
}
