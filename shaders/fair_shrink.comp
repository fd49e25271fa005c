// Halves the control points around every flagged vertex about it, and takes the flag down.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
UPDATE(2, uint, flags);
UPDATE(3, uint, halvings);
UPDATE(4, vec4, result);

const float kShrink = 0.5;

void main() {
  FOR_ELEMENTS(v) {
    FairVertex vertex = vertices_at(v);
    bool flagged = flags[v] != 0u;
    flags[v] = 0u;
    // Corner points and the curves that end there are where they must be.
    if (!flagged || vertex.kind == kCorner) continue;
    halvings[v] += 1u;
    for (uint i = vertex.first; i < vertex.first + vertex.count; ++i)
      result[places_at(i).corner] *= kShrink;
    if (vertex.kind != kCrease) continue;
    result[vertex.curve0] *= kShrink;
    result[vertex.curve1] *= kShrink;
  }
}
