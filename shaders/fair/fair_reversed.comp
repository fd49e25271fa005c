// Replaces every polygon that came out turned over, or was decided to have, by a small translated copy of the given points'.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, normals)
READ(3, vec4, given_offsets)
READ(4, vec2, circle)
UPDATE(5, vec4, result);
UPDATE(6, uint, decisions);

uint first_place;
#define POLYGON_POINT(i) result[places_at(first_place + (i)).corner].xyz
#include "fair_limit_normal.glsl"

// Cosine between the polygon's limit normal and the vertex's below which it is turned over.
const float kReversedCosine = 0.2;
const float kReversedFactor = 0.3;

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    if (!has_polygon(vertex)) continue;
    first_place = vertex.first;
    vec3 own = limit_normal(vertex.count, vertex.circle);
    bool reversed = dot(own, normals_at(v).xyz) < kReversedCosine * safe_length(own);
    if (parameters.decided != 0u) reversed = (decisions[v] & kReversed) != 0u;
    if (!reversed) continue;
    if (leads()) decisions[v] |= kReversed;
    vec3 mean = vec3(0.0);
    FOR_RING(p, vertex.first, vertex.count) mean += given_offsets_at(places_at(p).corner).xyz;
    mean = ring_sum(mean) / float(vertex.count);
    FOR_RING(p, vertex.first, vertex.count) {
      uint corner = places_at(p).corner;
      result[corner] = vec4(kReversedFactor * (given_offsets_at(corner).xyz - mean), 0.0);
    }
  }
}
