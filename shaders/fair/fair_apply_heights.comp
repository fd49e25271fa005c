// Moves the control points of every polygon by their heights, the third of a motion, as far as those can be trusted.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, directions)
READ(3, vec4, motions)
UPDATE(4, vec4, result);

#include "fair_walk.glsl"

// Of a control point's distance to the vertex.
const float kFarthestMove = 0.3;

void main() {
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    FairVertex vertex = vertices_at(v);
    if (!is_walked(vertex.count)) continue;
    vec3 direction = directions_at(v).xyz;
    float size = length(direction);
    if (!(size > 0.0)) continue;
    float mean = 0.0;
    FOR_RING(p, vertex.first, vertex.count) mean += motions_at(places_at(p).corner).z;
    mean = ring_sum(mean) / float(vertex.count);
    float scale = 1.0;
    FOR_RING(p, vertex.first, vertex.count) {
      uint c = places_at(p).corner;
      float move = abs(motions_at(c).z - mean) * size;
      float farthest = kFarthestMove * safe_length(result[c].xyz);
      if (move > farthest) scale = min(scale, farthest / move);
      if (!is_finite(move)) scale = 0.0;
    }
    scale = ring_min(scale);
    if (scale == 0.0) continue;
    FOR_RING(p, vertex.first, vertex.count) {
      uint c = places_at(p).corner;
      result[c].xyz += (motions_at(c).z - mean) * scale * direction;
    }
  }
}
