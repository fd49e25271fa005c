// The angle-weighted normal of the corners at a vertex; angle_weighted_normal() of
// fair/fair_topology.h. The including kernel declares places, given and face_normals.
#include "fair_walk.glsl"

// Of the sum of the angles: a normal below this is what cancellation left. Single precision leaves
// more of it than the twin's double.
const float kCancelled = 1e-5;
// Cosine between a corner's own normal and its face's from which the corner's counts alone; and sine
// of its angle: straight corners have no normal of their own.
const float kOwnNormalCosine = 0.5;
const float kStraightSine = 0.05;
const float kFullTurn = 6.28318531;

// How far a corner's own normal counts, 0 to 1; the rest is its face's.
float own_normal_part(vec3 a, vec3 b, vec3 c, float size, vec3 face_normal) {
  float cosine = dot(c / size, face_normal);
  float sine = size / safe_length(a) / safe_length(b);
  return clamp(cosine / kOwnNormalCosine, 0.0, 1.0) * min(sine / kStraightSine, 1.0);
}

// The angle from a to b counter-clockwise about a unit normal, 0 to a full turn.
float angle_about(vec3 a, vec3 b, vec3 c, vec3 normal) {
  float sine = dot(c, normal), cosine = dot(a, b) - dot(a, normal) * dot(b, normal);
  if (sine == 0.0 && cosine == 0.0) return 0.0;
  float angle = atan(sine, cosine);
  return angle < 0.0 ? angle + kFullTurn : angle;
}

vec3 angle_weighted_normal(vec3 origin, uint first, uint count) {
  vec3 sum = vec3(0.0);
  float angles = 0.0;
  FOR_RING(i, first, count) {
    FairPlace place = places_at(i);
    vec3 a = given_at(place.next).xyz - origin;
    vec3 b = given_at(place.previous).xyz - origin;
    vec3 c = cross(a, b);
    float size = safe_length(c);
    vec4 face_normal = face_normals_at(place.face);
    float own_part = 0.0;
    if (size > 0.0) {
      own_part = own_normal_part(a, b, c, size, face_normal.xyz);
      float own_angle = own_part * atan(size, dot(a, b));
      angles += own_angle;
      sum += c * (own_angle / size);
    } else if (face_normal.w == 3.0) {
      continue;  // without area: its face has no normal either
    }
    if (own_part == 1.0) continue;
    float face_angle = (1.0 - own_part) * angle_about(a, b, c, face_normal.xyz);
    angles += face_angle;
    sum += face_angle * face_normal.xyz;
  }
  sum = ring_sum(sum);
  float size = safe_length(sum);
  if (size > kCancelled * ring_sum(angles)) return sum / size;
  sum = vec3(0.0);
  FOR_RING(i, first, count) sum += face_normals_at(places_at(i).face).xyz;
  return normalised(ring_sum(sum));
}
