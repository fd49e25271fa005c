// The vector by which a height of 1 moves the control points around every vertex: its normal, but 0
// where they must stay or lie in a plane, and less near curves. polish_directions() of fair/polish.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, vec4, normals)
READ(2, float, shares)
WRITE(3, vec4, directions);

void main() {
  FOR_ELEMENTS(v) {
    FairVertex vertex = vertices_at(v);
    float part = has_polygon(vertex) && vertex.plane == 0u ? 1.0 : 0.0;
    if (vertex.near_curve != 0u) part *= 1.0 - shares_at(v);
    directions[v] = vec4(part * normals_at(v).xyz, 0.0);
  }
}
