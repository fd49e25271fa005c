// The residual after a step, less its mean over every polygon, and its preconditioned square sum.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, float, gradient)
READ(3, float, precondition)
READ_STORED(4, FairScalars, scalars);
UPDATE(5, float, residual);
WRITE(6, float, partials);

#include "fair_sum.glsl"

void main() {
  float total = 0.0;
  FOR_ELEMENTS(v) {
    FairVertex vertex = vertices_at(v);
    if (!has_polygon(vertex)) continue;
    float mean = 0.0;
    for (uint i = vertex.first; i < vertex.first + vertex.count; ++i) {
      uint c = places_at(i).corner;
      residual[c] -= scalars[0].step * gradient_at(c);
      mean += residual[c];
    }
    mean /= float(vertex.count);
    float square = 0.0;
    for (uint i = vertex.first; i < vertex.first + vertex.count; ++i) {
      uint c = places_at(i).corner;
      residual[c] -= mean;
      square += residual[c] * residual[c];
    }
    total += precondition_at(v) * square;
  }
  total = group_sum(total);
  if (gl_LocalInvocationIndex == 0u) partials[gl_WorkGroupID.x] = total;
}
