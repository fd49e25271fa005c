// Curve points at crease and boundary vertices are drawn back where they lead too far into a face.
// fair/crease_handle.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ_STORED(0, FairCrease, creases);
READ(1, vec4, given)
READ(2, FairPlace, places)
READ(3, vec4, face_normals)
READ(4, vec4, given_offsets)
UPDATE(5, vec4, result);

#include "fair_walk.glsl"

// How far a handle may lead into a face: of the way that the corner's own control point is from the curve, and
// of the other edge's distance.
const float kCorridor = 0.5, kCorridorOfEdge = 1.0 / 8.0;
const float kLeastCorridorFactor = 0.02;

// Wider corners than of 174 degrees in a triangle count as that.
const float kWidestSine = 0.1 / 6.0;

// In one face, between its sharp edge and its other one; `inward` at right angles to the former.
float face_factor(vec3 handle, vec3 sharp, vec3 inward, vec3 other, vec3 point) {
  float size = safe_length(inward);
  if (!(size > 0.0)) return 1.0;
  float lateral = dot(handle, inward / size);
  float most = min(kCorridor * dot(point, inward / size), kCorridorOfEdge * dot(other, inward / size));
  if (dot(other, sharp) < 0.0 || dot(other, inward) < 0.0)
    most = max(most, kCorridor * kWidestSine * safe_length(other));
  return most > 0.0 && lateral > most ? most / lateral : 1.0;
}

float corridor_factor(FairCrease crease, vec3 own, vec3 handle) {
  float factor = 1.0;
  FOR_RING(i, crease.first, crease.count) {
    FairPlace place = places_at(i);
    vec3 next = given_at(place.next).xyz - own, previous = given_at(place.previous).xyz - own;
    vec3 normal = face_normals_at(place.face).xyz, point = given_offsets_at(place.corner).xyz;
    if (place.next == crease.before || place.next == crease.after)
      factor = min(factor, face_factor(place.next == crease.before ? handle : -handle,
                                       next, cross(normal, next), previous, point));
    if (place.previous == crease.before || place.previous == crease.after)
      factor = min(factor, face_factor(place.previous == crease.before ? handle : -handle,
                                       previous, cross(previous, normal), next, point));
  }
  return max(ring_min(factor), kLeastCorridorFactor);
}

void main() {
  FOR_ELEMENTS(i) {
    FairCrease crease = creases[kShared ? creases[i].large : i];
    if (!is_walked(crease.count)) continue;
    vec3 handle = result[crease.curve0].xyz;
    float factor = corridor_factor(crease, given_at(crease.vertex).xyz, handle);
    if (!leads()) continue;
    result[crease.curve0] = vec4(factor * handle, 0.0);
    result[crease.curve1] = vec4(-factor * handle, 0.0);
  }
}
