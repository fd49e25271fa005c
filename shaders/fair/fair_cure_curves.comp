// Flags the ends of every sharp edge beside which the curve's own points and a face's first ones are
// turned over.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairFace, faces)
READ(1, uint, owners)
READ(2, FairLinks, links)
READ(3, vec4, given)
READ(4, vec4, face_normals)
READ(5, vec4, result)
UPDATE(6, uint, flags);

#include "fair_cure.glsl"
#include "fair_changed.glsl"
#include "fair_walk.glsl"

const float kPartOfBest = 0.5;

// The other curve point of the edge: they stand side by side.
uint other_end(uint point) {
  return parameters.corner_count + ((point - parameters.corner_count) ^ 1u);
}

void test_edge(uint corner, vec3 face_normal) {
  uint next = links_at(corner).next, points = parameters.corner_count;
  uint curve0 = links_at(corner).before, curve1 = links_at(next).after;
  if (curve0 < points && curve1 < points) return;
  // A dart's ring does not show its curve point: the edge's other one does.
  if (curve0 < points) curve0 = other_end(curve1);
  if (curve1 < points) curve1 = other_end(curve0);
  uint end0 = owners_at(corner), end1 = owners_at(next);
  if (!is_changed(end0) && !is_changed(end1)) return;
  vec3 on0 = result_at(curve0).xyz, on1 = result_at(curve1).xyz;
  vec3 along = (given_at(end1).xyz - given_at(end0).xyz) + (on1 - on0);
  vec3 across = (result_at(corner).xyz - on0) + (result_at(next).xyz - on1);
  if (cosine_of(cross(along, across), face_normal) >= kPartOfBest) return;
  atomicOr(flags[end0], kBad);
  atomicOr(flags[end1], kBad);
}

void main() {
  FOR_ELEMENTS(i) {
    uint f = ELEMENT(faces_at, i);
    FairFace face = faces_at(f);
    if (!is_walked(face.count)) continue;
    FOR_RING(c, face.first, face.count) test_edge(c, face_normals_at(f).xyz);
  }
}
