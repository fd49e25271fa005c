// One step of the masked iteration: every point moves by its share of the distance from its limit
// point to its given point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, float, shares)
READ(4, vec4, offsets)
READ(5, vec4, points)
WRITE(6, vec4, next);

#include "fair_walk.glsl"

vec3 limit_error(uint v, FairVertex vertex) {
  if (has_polygon(vertex)) {
    vec3 sum = vec3(0.0);
    FOR_RING(i, vertex.first, vertex.count) sum += offsets_at(places_at(i).corner).xyz;
    return ring_sum(sum) / float(vertex.count);
  }
  vec3 own = points_at(v).xyz;
  return (own - given_at(v).xyz) +
         ((points_at(vertex.before).xyz - own) + (points_at(vertex.after).xyz - own)) / 8.0;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    float share = shares_at(v);
    vec3 point = points_at(v).xyz;
    if (share > 0.0) {
      FairVertex vertex = vertices_at(v);
      if (!is_walked(vertex.count)) continue;
      point -= share * limit_error(v, vertex);
    } else if (kShared) {
      continue;  // a lane of its own moves it along
    }
    if (leads()) next[v] = vec4(point, 0.0);
  }
}
