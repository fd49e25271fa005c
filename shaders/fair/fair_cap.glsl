// Directions seen from the faces at a vertex; fair/smallest_cap.h. The including kernel declares
// places and face_normals.
#include "fair_walk.glsl"
FairVertex seen_vertex;

// The normal of the face that is seen worst from a direction, and its cosine with that.
vec4 worst_seen(vec3 direction) {
  vec4 worst = vec4(0.0, 0.0, 0.0, 2.0);
  FOR_RING(i, seen_vertex.first, seen_vertex.count) {
    vec3 normal = face_normals_at(places_at(i).face).xyz;
    float cosine = dot(direction, normal);
    if (cosine < worst.w) worst = vec4(normal, cosine);
  }
  return ring_least(worst);
}
vec3 as_view(vec3 v, vec3 otherwise) {
  float size = safe_length(v);
  return size > 0.0 ? v / size : otherwise;
}
#include "fair_best_view.glsl"

float least_face_cosine(FairVertex vertex, vec3 direction) {
  seen_vertex = vertex;
  return worst_seen(direction).w;
}

// The direction nearest to all of them, and the least cosine.
vec4 smallest_cap(FairVertex vertex, vec3 normal) {
  seen_vertex = vertex;
  return best_view(normal);
}

vec3 tilted_normal(FairVertex vertex, vec3 normal) {
  seen_vertex = vertex;
  return turned_to_see(normal);
}
