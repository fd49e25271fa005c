// How the plane of every new perpendicular polygon leans, where that is not chosen yet, and how far its
// points may lie from the vertex; at curves that alone. tilted_normal() of fair/smallest_cap.h,
// lean_towards(), perpendicular_size().
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, float, heights)
READ(5, vec2, circle)
READ_STORED(6, uint, flags);
UPDATE(7, vec4, planes);  // the lean, and the size

#include "fair_angles.glsl"
#include "fair_cap.glsl"
#include "fair_lean.glsl"

const int kTiltSteps = 8;
// Of the cap's cosine: what a normal must have with every face to be left as it is.
const float kSeenShare = 0.2;
// Of the least height of the faces around.
const float kSize = 0.5;

vec3 between(float share, vec3 normal, vec3 cap) {
  return normalised_or((1.0 - share) * normal + share * cap, cap);
}

vec3 tilted_normal(FairVertex vertex, vec3 normal) {
  vec4 cap = smallest_cap(vertex, normal);
  float wanted = kSeenShare * cap.w;
  if (cap.w <= 0.0 || least_face_cosine(vertex, normal) >= wanted) return normal;
  float least = 0.0, enough = 1.0;
  for (int step = 0; step < kTiltSteps; ++step) {
    float middle = (least + enough) / 2.0;
    if (least_face_cosine(vertex, between(middle, normal, cap.xyz)) >= wanted)
      enough = middle;
    else
      least = middle;
  }
  return between(enough, normal, cap.xyz);
}

float perpendicular_size(FairVertex vertex) {
  float least = 0.0;
  for (uint i = vertex.first; i < vertex.first + vertex.count; ++i) {
    float height = heights_at(places_at(i).face);
    if (height > 0.0 && (least == 0.0 || height < least)) least = height;
  }
  return kSize * least;
}

void main() {
  FOR_ELEMENTS(v) {
    if ((flags[v] & kRebuild) == 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (has_polygon(vertex) && planes[v].x >= NO_LEAN) {
      vec3 origin = given_at(v).xyz;
      vec3 normal = angle_weighted_normal(origin, vertex.first, vertex.count);
      planes[v].xy = lean_towards(vertex, origin, normal, tilted_normal(vertex, normal));
    }
    planes[v].z = perpendicular_size(vertex);
  }
}
