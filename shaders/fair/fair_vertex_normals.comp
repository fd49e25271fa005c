// The unit normal at every vertex: its corners' normals weighted by their angles, or that of the plane
// there.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, face_normals)
WRITE(4, vec4, normals);

#include "fair_angles.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    vec3 normal = vertex.plane != 0u
                      ? face_normals_at(vertex.plane - 1u).xyz
                      : angle_weighted_normal(given_at(v).xyz, vertex.first, vertex.count);
    if (leads()) normals[v] = vec4(normal, 0.0);
  }
}
