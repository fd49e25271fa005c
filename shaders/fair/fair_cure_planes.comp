// How the plane of every new perpendicular polygon leans, where that is not chosen yet, and how far its
// points may lie from the vertex; at curves that alone. tilted_normal() of fair/perpendicular_polygon.h,
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

// Of the least height of the faces around.
const float kSize = 0.5;
#define INFINITE uintBitsToFloat(0x7f800000u)

float perpendicular_size(FairVertex vertex) {
  float least = INFINITE;
  FOR_RING(i, vertex.first, vertex.count) {
    float height = heights_at(places_at(i).face);
    if (height > 0.0) least = min(least, height);
  }
  least = ring_min(least);
  return least < INFINITE ? kSize * least : 0.0;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    if ((flags[v] & kRebuild) == 0u) continue;
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    if (has_polygon(vertex) && planes[v].x >= NO_LEAN) {
      vec3 origin = given_at(v).xyz;
      vec3 normal = angle_weighted_normal(origin, vertex.first, vertex.count);
      vec2 lean = lean_towards(vertex, origin, normal, tilted_normal(vertex, normal));
      if (leads()) planes[v].xy = lean;
    }
    float size = perpendicular_size(vertex);
    if (leads()) planes[v].z = size;
  }
}
