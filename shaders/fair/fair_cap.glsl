// Directions seen from the faces at a vertex; fair/smallest_cap.h. The including kernel declares
// places and face_normals.
const int kCapSteps = 60;

// The normal of the face that is seen worst from a direction, and its cosine with that.
vec4 worst_face(FairVertex vertex, vec3 direction) {
  vec4 worst = vec4(0.0, 0.0, 0.0, 2.0);
  for (uint i = vertex.first; i < vertex.first + vertex.count; ++i) {
    vec3 normal = face_normals_at(places_at(i).face).xyz;
    float cosine = dot(direction, normal);
    if (cosine < worst.w) worst = vec4(normal, cosine);
  }
  return worst;
}
float least_face_cosine(FairVertex vertex, vec3 direction) {
  return worst_face(vertex, direction).w;
}

vec3 normalised_or(vec3 v, vec3 otherwise) {
  float size = safe_length(v);
  return size > 0.0 ? v / size : otherwise;
}

// The direction nearest to all of them, and the least cosine.
vec4 smallest_cap(FairVertex vertex, vec3 normal) {
  vec4 best = vec4(normal, -2.0);
  vec3 direction = normal;
  for (int step = 0; step < kCapSteps; ++step) {
    vec4 worst = worst_face(vertex, direction);
    if (worst.w > best.w) best = vec4(direction, worst.w);
    direction = normalised_or(direction + (worst.xyz - direction) / (2.0 + float(step)), direction);
  }
  return best;
}
