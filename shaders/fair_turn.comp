// Takes the step along the direction of every control point, then turns the direction.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairCorner, corners);
READ(1, float, precondition);
READ(2, FairScalars, scalars);
READ(3, float, residual);
UPDATE(4, float, direction);
UPDATE(5, float, heights);

void main() {
  FOR_ELEMENTS(c) {
    float along = direction[c];
    heights[c] += scalars[0].step * along;
    direction[c] =
        precondition[corners[c].vertex] * residual[c] + scalars[0].momentum * along;
  }
}
