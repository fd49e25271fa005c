// The limit normal at the centre of a polygon of control points; the including kernel declares
// POLYGON_POINT(i) and circle.
#include "fair_walk.glsl"
vec3 limit_normal(uint count, uint circle_first) {
  if (count < 3u) return vec3(0.0);
  vec3 origin = POLYGON_POINT(0u);
  if (count == 3u) return cross(POLYGON_POINT(1u) - origin, POLYGON_POINT(2u) - origin);
  if (count == 4u)
    return cross(origin - POLYGON_POINT(2u), POLYGON_POINT(1u) - POLYGON_POINT(3u));
  vec3 tangent1 = vec3(0.0), tangent2 = vec3(0.0);
  FOR_RING(i, 1u, count - 1u) {
    vec3 p = POLYGON_POINT(i) - origin;
    tangent1 += circle_at(circle_first + i).x * p;
    tangent2 += circle_at(circle_first + i).y * p;
  }
  return cross(ring_sum(tangent1), ring_sum(tangent2));
}
