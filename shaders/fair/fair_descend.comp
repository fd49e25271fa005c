// The step along the direction of every control point: its height, its residual after it, and the
// residuals' preconditioned square sum, by whose change the last direction is part of the next one.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairVertex, vertices)
READ(1, FairPlace, places)
READ(2, float, gradient)
READ(3, float, precondition)
READ(4, vec4, motions)
UPDATE(5, FairScalars, scalars);
WRITE(6, vec4, next);
UPDATE_TOGETHER(7, float, partials);

#include "fair_motion.glsl"
#include "fair_total.glsl"
#include "fair_walk.glsl"

// Of the first residual's square: single precision reaches no lower.
const float kConverged = 1e-12;

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

void write_momentum(float square) {
  if (parameters.start != 0u) {
    scalars[0].step = 0.0;
    scalars[0].momentum = 0.0;
    scalars[0].enough = kConverged * square;
  } else {
    float momentum = scalars[0].square > 0.0 ? square / scalars[0].square : 0.0;
    scalars[0].momentum = is_finite(momentum) ? momentum : 0.0;
  }
  scalars[0].square = square;
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
  if (is_total(total)) write_momentum(total);
}
