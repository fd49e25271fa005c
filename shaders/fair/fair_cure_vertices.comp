// Flags every smooth or dart vertex whose limit normal is turned too far from its faces, and notes where
// faces are so uneven that the places around it are to be looked at.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, face_normals)
READ(3, vec4, normals)
READ(4, vec4, result)
READ(5, vec2, circle)
UPDATE(6, uint, flags);

#include "fair_cure.glsl"
#include "fair_cap.glsl"
uint first_place;
#define POLYGON_POINT(i) result_at(places_at(first_place + (i)).corner).xyz
#include "fair_limit_normal.glsl"

const float kPartOfBestAtVertices = 0.1;
const float kPartOfBestAround = 0.5;
const float kLeastBest = 0.02;
// Of the vertex's normal with its faces, from which its surroundings are even.
const float kFlatCosine = 0.9;

// What the vertex's word says beside that it was touched or changed.
uint look_at(uint v, FairVertex vertex) {
  first_place = vertex.first;
  vec3 normal = limit_normal(vertex.count, vertex.circle);
  float size = safe_length(normal);
  float own = size > 0.0 ? least_face_cosine(vertex, normal / size) : -1.0;
  if (own >= kPartOfBestAtVertices && least_face_cosine(vertex, normals_at(v).xyz) >= kFlatCosine)
    return 0u;
  float best = smallest_cap(vertex, normals_at(v).xyz).w;
  if (best < kLeastBest) return 0u;
  if (own < kPartOfBestAtVertices * best) return kBad;
  return floatBitsToUint(kPartOfBestAround * best) & ~kCureFlags;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i), word = flags[v];
    if ((word & kTouched) == 0u || (word & kBad) != 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || !has_polygon(vertex)) continue;
    uint found = look_at(v, vertex);
    if (leads()) flags[v] = (word & (kTouched | kChanged)) | found;
  }
}
