// Flags the ends of every smooth edge whose polygon is turned away from the mesh.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairEdge, edges)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, vec4, result)
UPDATE(5, uint, flags);
UPDATE(6, uint, counts);

#include "fair_fold.glsl"


void main() {
  FOR_ELEMENTS(e) {
    FairEdge edge = edges_at(e);
    // In differences of given points, which are exact where they are near each other.
    uint end0 = owners_at(edge.corner0), end1 = owners_at(edge.corner1);
    vec3 between = given_at(end1).xyz - given_at(end0).xyz;
    vec3 diagonal0 = between + (result_at(edge.corner2).xyz - result_at(edge.corner0).xyz);
    vec3 diagonal1 = (result_at(edge.corner3).xyz - result_at(edge.corner1).xyz) - between;
    vec3 bisector = face_normals_at(edge.face0).xyz + face_normals_at(edge.face1).xyz;
    float size = safe_length(bisector);
    if (!(size > 0.0)) continue;  // a knife's edge has no normal to compare with
    // Less is asked of sharp ones: half the size is the cosine of half their turn.
    if (agrees(cross(diagonal0, diagonal1), bisector / size, kLeastCosine * size / 2.0)) continue;
    atomicAdd(counts[parameters.place], 1u);
    atomicOr(flags[end0], 1u);
    atomicOr(flags[end1], 1u);
  }
}
