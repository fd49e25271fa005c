// How far every vertex takes part in the tensor-product construction, 0 to 1: only among quads, and
// the less the farther it is out of balance, be it by itself or against its neighbours.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, offsets)
READ(4, vec4, normals)
READ(5, vec4, errors)  // of large vertices
WRITE(6, float, shares);

#include "fair_crease.glsl"
#include "fair_ring.glsl"

// Such an imbalance counts this much; fair/tensor_share.h.
const float kRelativeWeight = 2.0;
const float kFullShareBelow = 0.4, kNoShareFrom = 0.9;

// How far the limit point of the given points is from its vertex; limit_error() of
// fair/masked_iteration.h.
vec3 limit_error(uint v) {
  FairVertex vertex = vertices_at(v);
  if (has_polygon(vertex)) {
    if (vertex.count >= kLargeRing) return errors_at(v).xyz;
    vec3 sum = vec3(0.0);
    for (uint i = vertex.first; i < vertex.first + vertex.count; ++i)
      sum += offsets_at(places_at(i).corner).xyz;
    return sum / float(vertex.count);
  }
  if (vertex.kind == kCorner) return vec3(0.0);
  vec3 own = given_at(v).xyz;
  return ((given_at(vertex.before).xyz - own) + (given_at(vertex.after).xyz - own)) / 8.0;
}

vec3 relative_error(uint v, FairVertex vertex) {
  vec3 around = vec3(0.0);
  FOR_RING(i, vertex.first, vertex.count) around += limit_error(places_at(i).next);
  return limit_error(v) - ring_sum(around) / float(vertex.count);
}

float share_of_imbalance(float rho) {
  return clamp((kNoShareFrom - rho) / (kNoShareFrom - kFullShareBelow), 0.0, 1.0);
}

float share_of(uint v, FairVertex vertex) {
  if (vertex.regular == 0u || vertex.kind == kCorner || vertex.plane != 0u) return 0.0;
  vec3 own = given_at(v).xyz;
  if (vertex.kind == kCrease)
    return share_of_imbalance(arm_imbalance(CreaseArms((given_at(vertex.before).xyz - own) / 4.0,
                                                       (given_at(vertex.after).xyz - own) / 4.0)));
  Ring ring = ring_of(v, normals_at(v).xyz);
  float rho = imbalance(ring);
  if (rho <= kFullShareBelow) return 1.0;
  ring.mean = project(ring.frame, relative_error(v, vertex));
  return share_of_imbalance(min(rho, kRelativeWeight * imbalance(ring)));
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    float share = share_of(v, vertex);
    if (leads()) shares[v] = share;
  }
}
