// Flags the vertices of every face whose polygon is turned away from the mesh.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, vec4, result)
READ(5, vec2, circle)
UPDATE(6, uint, flags);
UPDATE(7, uint, counts);

#include "fair_fold.glsl"
uint first_corner;
#define POLYGON_POINT(i) control_point(first_corner + (i))
#include "fair_limit_normal.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    first_corner = face.first;
    if (agrees(limit_normal(face.count, face.circle), face_normals_at(f).xyz, kLeastCosine)) continue;
    if (leads()) atomicAdd(counts[parameters.place + 1u], 1u);
    FOR_RING(c, face.first, face.count) atomicOr(flags[owners_at(c)], 1u);
  }
}
