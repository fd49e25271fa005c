// Lets the next round of repair run where this one found something turned over, and be empty else.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ_STORED(0, uint, counts);
WRITE(1, uint, arguments);

void write_groups(uint dispatch, uint groups) {
  arguments[kArgumentWords * dispatch] = groups;
  arguments[kArgumentWords * dispatch + 1u] = 1u;
  arguments[kArgumentWords * dispatch + 2u] = 1u;
}

void main() {
  if (gl_GlobalInvocationID.x != 0u) return;
  bool found = counts[parameters.place] + counts[parameters.place + 1u] > 0u;
  write_groups(kRoundEdges, found ? parameters.edge_groups : 0u);
  write_groups(kRoundFaces, found ? parameters.face_groups : 0u);
  write_groups(kRoundVertices, found ? parameters.vertex_groups : 0u);
  write_groups(kRoundLargeFaces, found ? parameters.large_face_groups : 0u);
  write_groups(kRoundLargeVertices, found ? parameters.large_vertex_groups : 0u);
}
