// Measures how far the limit point of every vertex is from its given point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, given)
READ(3, vec4, result)
UPDATE(4, uint, status);  // words of SolveStatus

#include "fair_walk.glsl"

const uint kStateWord = 1u, kResidualWord = 2u;

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    vec3 given_point = given_at(v).xyz, error = vec3(0.0);
    if (has_polygon(vertex)) {
      FOR_RING(p, vertex.first, vertex.count) error += result_at(places_at(p).corner).xyz;
      error = ring_sum(error) / float(vertex.count);
    } else if (vertex.kind == kCrease) {
      error += (result_at(vertex.curve0).xyz + result_at(vertex.curve1).xyz) / 2.0;
    }
    if (!leads()) continue;
    float size = parameters.scale * safe_length(error);
    // What stands around a given point that is no number may be replaced by numbers.
    bool finite = is_finite(error.x + error.y + error.z) &&
                  is_finite(given_point.x + given_point.y + given_point.z);
    if (!finite) atomicMax(status[kStateWord], kStateNotFinite);
    atomicMax(status[kResidualWord], finite ? floatBitsToUint(size) : 0x7f800000u);
  }
}
