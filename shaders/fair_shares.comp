// How far every vertex takes part in the tensor-product construction, 0 to 1: only among quads, and
// the less the farther it is out of balance.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, offsets)
READ(4, vec4, normals)
WRITE(5, float, shares);

#include "fair_crease.glsl"
#include "fair_ring.glsl"

// tensor_share() of fair/masked_iteration.h.
float tensor_share(float rho) { return clamp((0.9 - rho) / (0.9 - 0.4), 0.0, 1.0); }

float share_of(uint v) {
  FairVertex vertex = vertices_at(v);
  if (vertex.regular == 0u || vertex.kind == kCorner) return 0.0;
  vec3 own = given_at(v).xyz;
  if (vertex.kind == kCrease)
    return tensor_share(arm_imbalance(CreaseArms((given_at(vertex.before).xyz - own) / 4.0,
                                                 (given_at(vertex.after).xyz - own) / 4.0)));
  return tensor_share(imbalance(ring_of(v, normals_at(v).xyz)));
}

void main() {
  FOR_ELEMENTS(v) shares[v] = share_of(v);
}
