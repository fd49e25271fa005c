// Takes the step along the direction of every control point, then turns the direction.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, uint, owners)
READ(1, float, precondition)
READ_STORED(2, FairScalars, scalars);
READ(3, float, residual)
UPDATE(4, float, direction);
UPDATE(5, float, heights);

void main() {
  FOR_ELEMENTS(c) {
    float along = direction[c];
    heights[c] += scalars[0].step * along;
    direction[c] =
        precondition_at(owners_at(c)) * residual_at(c) + scalars[0].momentum * along;
  }
}
