// Flags the ends of every smooth edge whose limit normal is turned too far from the faces beside it, or
// counts the edges that are turned over. NetSamples::at_edge() of fair/net_samples.h.
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

#include "fair_cure.glsl"
#include "fair_changed.glsl"

// Of the best cosine that any normal there can have; and where that is less, about 80 degrees, the
// mesh itself is folded.
const float kPartOfBest = 0.5;
const float kLeastBest = 0.17;

// The cross product of the polygon's diagonals: written out, since the edge, which they both follow,
// is long beside what is left.
vec3 limit_normal(FairEdge edge, vec3 along) {
  vec3 a = result_at(edge.corner2).xyz - result_at(edge.corner0).xyz;
  vec3 b = result_at(edge.corner3).xyz - result_at(edge.corner1).xyz;
  return cross(along, a + b) + cross(a, b);
}

void main() {
  FOR_ELEMENTS(e) {
    FairEdge edge = edges_at(e);
    uint end0 = owners_at(edge.corner0), end1 = owners_at(edge.corner1);
    bool only_counts = parameters.only_counts != 0u;
    if (!only_counts && !is_changed(end0) && !is_changed(end1)) continue;
    vec3 normal = limit_normal(edge, given_at(end1).xyz - given_at(end0).xyz);
    vec3 face0 = face_normals_at(edge.face0).xyz, face1 = face_normals_at(edge.face1).xyz;
    float cosine = min(cosine_of(normal, face0), cosine_of(normal, face1));
    if (only_counts) {
      if (cosine < 0.0) atomicAdd(counts[parameters.place], 1u);
      continue;
    }
    float best = sqrt(max(0.0, (1.0 + dot(face0, face1)) / 2.0));
    if (best < kLeastBest || cosine >= kPartOfBest * best) continue;
    atomicOr(flags[end0], kBad);
    atomicOr(flags[end1], kBad);
  }
}
