// Moves the control points of every polygon by their heights, the third of a motion, as far as those can be trusted.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, vec4, directions)
READ(3, vec4, motions)
UPDATE(4, vec4, result);

// Of a control point's distance to the vertex.
const float kFarthestMove = 0.3;

void main() {
  FOR_ELEMENTS(v) {
    FairVertex vertex = vertices_at(v);
    vec3 direction = directions_at(v).xyz;
    float size = length(direction);
    if (!(size > 0.0)) continue;
    uint end = vertex.first + vertex.count;
    float mean = 0.0;
    for (uint i = vertex.first; i < end; ++i) mean += motions_at(places_at(i).corner).z;
    mean /= float(vertex.count);
    float scale = 1.0;
    for (uint i = vertex.first; i < end; ++i) {
      uint c = places_at(i).corner;
      float move = abs(motions_at(c).z - mean) * size;
      float farthest = kFarthestMove * safe_length(result[c].xyz);
      if (move > farthest) scale = min(scale, farthest / move);
      if (!is_finite(move)) scale = 0.0;
    }
    if (scale == 0.0) continue;
    for (uint i = vertex.first; i < end; ++i) {
      uint c = places_at(i).corner;
      result[c].xyz += (motions_at(c).z - mean) * scale * direction;
    }
  }
}
