// The direction from which the worst of some vectors is seen best; fair/perpendicular_polygon.h. The vectors are the
// normals of the faces at a vertex, fair/perpendicular_polygon.h: the including kernel declares places and
// face_normals. fair_cure_creases has a worst_seen() and an as_view() of its own.
#include "fair_walk.glsl"

#ifndef KERNEL_fair_cure_creases
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
#endif

// What of a triangle is nearest to the origin; corners may be the same. Ericson, "Real-Time Collision
// Detection", 5.1.5. Differences of equal products are zero only where they are not fused with one of
// them: else a doubled corner is taken for a triangle.
vec3 nearest_in_triangle(vec3 a, vec3 b, vec3 c) {
  vec3 ab = b - a, ac = c - a;
  float ab_a = -dot(ab, a), ac_a = -dot(ac, a);
  if (ab_a <= 0.0 && ac_a <= 0.0) return a;
  float ab_b = -dot(ab, b), ac_b = -dot(ac, b);
  if (ab_b >= 0.0 && ac_b <= ab_b) return b;
  precise float w_ab = ab_a * ac_b - ab_b * ac_a;
  if (w_ab <= 0.0 && ab_a >= 0.0 && ab_b <= 0.0) return a + ab_a / (ab_a - ab_b) * ab;
  float ab_c = -dot(ab, c), ac_c = -dot(ac, c);
  if (ac_c >= 0.0 && ab_c <= ac_c) return c;
  precise float w_ac = ab_c * ac_a - ab_a * ac_c;
  if (w_ac <= 0.0 && ac_a >= 0.0 && ac_c <= 0.0) return a + ac_a / (ac_a - ac_c) * ac;
  precise float w_bc = ab_b * ac_c - ab_c * ac_b;
  float to_c = ac_b - ab_b, to_b = ab_c - ac_c;
  if (w_bc <= 0.0 && to_c >= 0.0 && to_b >= 0.0) return b + to_c / (to_c + to_b) * (c - b);
  // Of the plane; weights would lose digits where corners are close together.
  precise vec3 normal = vec3(ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z,
                             ab.x * ac.y - ab.y * ac.x);
  float square = dot(normal, normal);
  return square > 0.0 ? dot(normal, a) / square * normal : a;
}

vec4 best_view(vec3 start) {
  const int kMostSteps = 40;
  const float kLeastCosine = 1e-5;
  vec3 a = worst_seen(start).xyz, b = a, c = a, nearest = a;
  vec4 best = vec4(start, 0.0);
  for (int step = 0; step < kMostSteps; ++step) {
    float size = length(nearest);
    if (!(size > kLeastCosine)) return vec4(start, 0.0);
    vec4 worst = worst_seen(nearest / size);
    bool is_last = worst.xyz == a || worst.xyz == b || worst.xyz == c;
    if (worst.w > best.w || is_last) best = vec4(nearest / size, worst.w);
    if (is_last) break;
    // The nearest point of the four corners' hull is in a triangle with the new one.
    vec3 in_a = nearest_in_triangle(worst.xyz, b, c), in_b = nearest_in_triangle(a, worst.xyz, c);
    vec3 in_c = nearest_in_triangle(a, b, worst.xyz);
    float of_a = dot(in_a, in_a), of_b = dot(in_b, in_b), of_c = dot(in_c, in_c);
    float least = min(of_a, min(of_b, of_c));
    if (!(least < (1.0 + 1e-6) * size * size)) break;
    if (least == of_a) {
      a = worst.xyz;
      nearest = in_a;
    } else if (least == of_b) {
      b = worst.xyz;
      nearest = in_b;
    } else {
      c = worst.xyz;
      nearest = in_c;
    }
  }
  return best;
}

vec3 turned_to_see(vec3 own) {
  const int kTurnSteps = 20;
  const float kSeenShare = 0.2;
  vec4 best = best_view(own);
  float wanted = kSeenShare * best.w;
  if (best.w <= 0.0 || worst_seen(own).w >= wanted) return own;
  float least = 0.0, enough = 1.0;
  for (int step = 0; step < kTurnSteps; ++step) {
    float middle = (least + enough) / 2.0;
    if (worst_seen(as_view((1.0 - middle) * own + middle * best.xyz, best.xyz)).w >= wanted)
      enough = middle;
    else
      least = middle;
  }
  return as_view((1.0 - enough) * own + enough * best.xyz, best.xyz);
}

#ifndef KERNEL_fair_cure_creases
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
#endif
