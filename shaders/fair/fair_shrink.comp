// Halves the control points around every flagged vertex about it and takes the flag down, or halves
// them as often as was decided.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
UPDATE(2, uint, flags);
UPDATE(3, uint, decisions);
UPDATE(4, vec4, result);

#include "fair_walk.glsl"

uint halvings_of(uint v, uint kind) {
  if (parameters.decided != 0u) return decisions[v] >> parameters.shift & kHalvingsMask;
  if (flags[v] == 0u) return 0u;
  ring_sync();
  if (leads()) flags[v] = 0u;
  // Corner points and the curves that end there are where they must be.
  if (kind == kCorner) return 0u;
  if (leads()) decisions[v] += 1u << parameters.shift;
  return 1u;
}

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    uint halvings = halvings_of(v, vertex.kind);
    if (halvings == 0u) continue;
    float factor = ldexp(1.0, -int(halvings));
    FOR_RING(p, vertex.first, vertex.count) result[places_at(p).corner] *= factor;
    if (vertex.kind != kCrease || !leads()) continue;
    result[vertex.curve0] *= factor;
    result[vertex.curve1] *= factor;
  }
}
