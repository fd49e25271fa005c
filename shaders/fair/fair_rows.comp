// The bending of the two lines through every control point, linear in heights along the directions.
// fair/bending_rows.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairLinks, links)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, directions)
READ(4, vec4, result)
WRITE(5, vec4, rows1);  // coefficients of next, own, after; value
WRITE(6, vec4, rows2);  // of previous, own, before; value

// A part of a line below this of the whole measures noise.
const float kShortestPart = 0.001;
// A line whose numbers leave single precision is no line.
const float kLargestCoefficient = 1e15;

vec4 row(vec3 to_far, vec3 to_near, vec3 normal, vec3 own_direction, vec3 far_direction) {
  float far_length = safe_length(to_far), near_length = safe_length(to_near);
  float whole = far_length + near_length;
  float part = min(far_length, near_length) / whole;
  if (!(part > kShortestPart)) return vec4(0.0);
  // A ramp to full weight, so that no line appears at once in a deforming mesh.
  float scale = 2.0 * min((part - kShortestPart) / kShortestPart, 1.0) / whole;
  float far = scale / far_length, near = scale / near_length;
  if (!(max(far, near) * length(normal) < kLargestCoefficient)) return vec4(0.0);
  float move = dot(normal, own_direction);
  return vec4(far * dot(normal, far_direction), -(far + near) * move, near * move,
              dot(normal, far * to_far + near * to_near));
}

void main() {
  FOR_ELEMENTS(c) {
    FairLinks corner = links_at(c);
    uint vertex = owners_at(c);
    vec3 own = result_at(c).xyz, origin = given_at(vertex).xyz;
    uint next = owners_at(corner.next), previous = owners_at(corner.previous);
    vec3 to_next = (given_at(next).xyz - origin) + (result_at(corner.next).xyz - own);
    vec3 to_previous = (given_at(previous).xyz - origin) + (result_at(corner.previous).xyz - own);
    // Control points around the same vertex differ by their offsets alone.
    vec3 to_after = result_at(corner.after).xyz - own;
    vec3 to_before = result_at(corner.before).xyz - own;
    // Of the quad of the four neighbours, scaled to the square root of half its area.
    vec3 normal = cross(to_next - to_after, to_previous - to_before);
    float size = safe_length(normal);
    rows1[c] = vec4(0.0);
    rows2[c] = vec4(0.0);
    if (!(size > 0.0)) continue;
    normal *= 0.5 / sqrt(size);
    vec3 move = directions_at(vertex).xyz;
    rows1[c] = row(to_next, to_after, normal, move, directions_at(next).xyz);
    rows2[c] = row(to_previous, to_before, normal, move, directions_at(previous).xyz);
  }
}
