// How far the limit point of the given points is from every large smooth or dart vertex, once and not
// once for each of its neighbours; limit_error() of fair/masked_iteration.h.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, offsets)
WRITE(3, vec4, errors);

#include "fair_walk.glsl"

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count) || !has_polygon(vertex)) continue;
    vec3 sum = vec3(0.0);
    FOR_RING(p, vertex.first, vertex.count) sum += offsets_at(places_at(p).corner).xyz;
    sum = ring_sum(sum);
    if (leads()) errors[v] = vec4(sum / float(vertex.count), 0.0);
  }
}
