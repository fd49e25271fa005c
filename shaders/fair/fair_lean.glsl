// How planes of cured polygons lean; fair/plane_lean.h. The including kernel declares places, given and
// circle.
#include "fair_plane.glsl"
#include "fair_walk.glsl"

#define NO_LEAN uintBitsToFloat(kNoLeanBits)

// Where the edges around a smooth or dart vertex point to, turning with the ring.
vec2 ring_direction(FairVertex vertex, vec3 origin, Frame frame) {
  vec2 sum = vec2(0.0);
  FOR_RING(i, 0u, vertex.count) {
    vec2 edge = project(frame, given_at(places_at(vertex.first + i).next).xyz - origin);
    float size = safe_length(vec3(edge, 0.0));
    vec2 back = circle_at(vertex.circle + i);
    if (size > 0.0) sum += vec2(dot(edge / size, back), turn(back, edge / size));
  }
  sum = ring_sum(sum);
  float size = length(sum);
  return size > 0.0 ? sum / size : vec2(1.0, 0.0);
}

// Along that direction and left of it, in space.
struct RingAxes {
  vec3 along, left;
};
RingAxes ring_axes(FairVertex vertex, vec3 origin, vec3 normal) {
  Frame frame = frame_of(normal);
  vec2 direction = ring_direction(vertex, origin, frame);
  return RingAxes(lift(frame, direction), lift(frame, vec2(-direction.y, direction.x)));
}

vec2 lean_towards(FairVertex vertex, vec3 origin, vec3 normal, vec3 target) {
  if (target == normal) return vec2(0.0);
  RingAxes axes = ring_axes(vertex, origin, normal);
  vec2 flat_target = vec2(dot(target, axes.along), dot(target, axes.left));
  float sine = length(flat_target);
  return sine > 0.0 ? atan(sine, dot(target, normal)) / sine * flat_target : vec2(0.0);
}

vec3 leaning_normal(FairVertex vertex, vec3 origin, vec3 normal, vec2 lean) {
  float angle = length(lean);
  if (!(angle > 0.0)) return normal;
  RingAxes axes = ring_axes(vertex, origin, normal);
  return normalize(cos(angle) * normal +
                   sin(angle) / angle * (lean.x * axes.along + lean.y * axes.left));
}
