// One Doo-Sabin step of points: every corner's control point relative to its vertex's given point.
// Based on: Doo & Sabin 1978; fair/corner_offsets.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, points)
READ(4, vec2, circle)
WRITE(5, vec4, offsets);

#include "fair_walk.glsl"

// Of the net, whose points are offsets of corners: what all are relative to.
vec3 origin = vec3(0.0);
vec3 given_of(uint corner) { return given_at(owners_at(corner)).xyz - origin; }
vec3 point(uint corner) {
  return parameters.of_net != 0u ? given_of(corner) + points_at(corner).xyz
                                 : points_at(owners_at(corner)).xyz;
}
void write_offset(uint corner, vec3 from, vec3 step) {
  offsets[corner] = vec4((from - given_of(corner)) + step, 0.0);
}

void step_triangle(uint first) {
  for (uint i = 0u; i < 3u; ++i) {
    vec3 own = point(first + i);
    write_offset(first + i, own,
                 (point(first + (i + 1u) % 3u) - own) / 6.0 +
                     (point(first + (i + 2u) % 3u) - own) / 6.0);
  }
}

void step_quad(uint first) {
  for (uint i = 0u; i < 4u; ++i) {
    vec3 own = point(first + i);
    write_offset(first + i, own,
                 (3.0 * (point(first + (i + 1u) % 4u) - own) +
                  3.0 * (point(first + (i + 3u) % 4u) - own) +
                  (point(first + (i + 2u) % 4u) - own)) /
                     16.0);
  }
}

void step_polygon(FairFace face) {
  vec3 middle = point(face.first);
  vec3 mean = vec3(0.0), cosine_sum = vec3(0.0), sine_sum = vec3(0.0);
  FOR_RING(i, 0u, face.count) {
    vec3 p = point(face.first + i) - middle;
    mean += p;
    cosine_sum += circle_at(face.circle + i).x * p;
    sine_sum += circle_at(face.circle + i).y * p;
  }
  mean = ring_sum(mean) / float(face.count);
  cosine_sum = ring_sum(cosine_sum);
  sine_sum = ring_sum(sine_sum);
  FOR_RING(i, 0u, face.count) {
    vec2 at = circle_at(face.circle + i);
    write_offset(face.first + i, middle,
                 0.25 * (point(face.first + i) - middle) + 0.75 * mean +
                     (at.x * cosine_sum + at.y * sine_sum) / (2.0 * float(face.count)));
  }
}

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    if (parameters.of_net != 0u) origin = given_at(owners_at(face.first)).xyz;
    if (face.count == 3u)
      step_triangle(face.first);
    else if (face.count == 4u)
      step_quad(face.first);
    else
      step_polygon(face);
  }
}
