// The angle-weighted normal of the corners at a vertex; angle_weighted_normal() of
// fair/vertex_frame.h. The including kernel declares places, given and face_normals.

// Of the sum of the angles: a normal below this is what cancellation left. Single precision leaves
// more of it than the twin's double.
const float kCancelled = 1e-5;

vec3 angle_weighted_normal(vec3 origin, uint first, uint count) {
  vec3 sum = vec3(0.0);
  float angles = 0.0;
  for (uint i = first; i < first + count; ++i) {
    FairPlace place = places_at(i);
    vec3 a = given_at(place.next).xyz - origin;
    vec3 b = given_at(place.previous).xyz - origin;
    vec3 c = cross(a, b);
    float size = safe_length(c);
    float angle = size > 0.0 || dot(a, b) != 0.0 ? atan(size, dot(a, b)) : 0.0;
    angles += angle;
    if (size > 0.0) sum += c * (angle / size);
  }
  float size = safe_length(sum);
  if (size > kCancelled * angles) return sum / size;
  sum = vec3(0.0);
  for (uint i = first; i < first + count; ++i) sum += face_normals_at(places_at(i).face).xyz;
  return normalised(sum);
}
