// The step along the direction of every control point: its height, its residual after it, and the
// residuals' preconditioned square sum.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, float, gradient)
READ(3, float, precondition)
READ(4, vec4, motions)
READ_STORED(5, FairScalars, scalars);
WRITE(6, vec4, next);
WRITE(7, float, partials);

#include "fair_motion.glsl"
#include "fair_walk.glsl"

// Returns the square sum of what the lane walks around.
float descend(FairVertex vertex, float scale, float step, float momentum) {
  float mean = 0.0;
  FOR_RING(i, vertex.first, vertex.count) mean += gradient_at(places_at(i).corner);
  mean = ring_sum(mean) / float(vertex.count);
  float square = 0.0;
  FOR_RING(i, vertex.first, vertex.count) {
    uint c = places_at(i).corner;
    vec4 motion = motions_at(c);
    float along = turned(motion, momentum);
    float residual = motion.x - scale * step * (gradient_at(c) - mean);
    next[c].xyz = vec3(residual, along, motion.z + step * along);
    square += residual * residual;
  }
  return square / scale;
}

void main() {
  float total = 0.0;
  float step = scalars[0].step, momentum = scalars[0].momentum;
  FOR_ELEMENTS(i) {
    uint v = ELEMENT(vertices_at, i);
    float scale = precondition_at(v);
    // Control points that must stay, or without lines, have no motion.
    if (!(scale > 0.0)) continue;
    FairVertex vertex = vertices_at(v);
    if (is_walked(vertex.count)) total += descend(vertex, scale, step, momentum);
  }
  total = group_sum(total);
  if (gl_LocalInvocationIndex == 0u) partials[parameters.first_partial + gl_WorkGroupID.x] = total;
}
