// Flags the vertices of every face whose limit normal is turned too far from it, and those that share a
// face with a changed one; or counts the faces that are turned over.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, vec4, given)
READ(3, vec4, face_normals)
READ(4, vec4, result)
READ(5, vec2, circle)
UPDATE(6, uint, flags);
UPDATE(7, uint, counts);

#include "fair_cure.glsl"
#include "fair_changed.glsl"

const float kPartOfBest = 0.5;

// Control points relative to the face's first vertex.
uint first_corner;
vec3 origin;
vec3 face_point(uint i) {
  uint corner = first_corner + i;
  return (given_at(owners_at(corner)).xyz - origin) + result_at(corner).xyz;
}
#define POLYGON_POINT(i) face_point(i)
#include "fair_limit_normal.glsl"

bool any_changed(FairFace face) {
  bool is_any = false;
  FOR_RING(c, face.first, face.count) {
    is_any = is_changed(owners_at(c));
    if (is_any) break;
  }
  return ring_any(is_any);
}

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    bool only_counts = parameters.only_counts != 0u;
    if (!only_counts && !any_changed(face)) continue;
    first_corner = face.first;
    origin = given_at(owners_at(first_corner)).xyz;
    float cosine = cosine_of(limit_normal(face.count, face.circle), face_normals_at(f).xyz);
    if (only_counts) {
      if (cosine < 0.0 && leads()) atomicAdd(counts[parameters.place], 1u);
      continue;
    }
    uint found = cosine < kPartOfBest ? kTouched | kBad : kTouched;
    FOR_RING(c, face.first, face.count) atomicOr(flags[owners_at(c)], found);
  }
}
