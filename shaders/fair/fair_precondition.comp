// One over the mean diagonal of every vertex, floored; 0 where control points must stay.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

UPDATE(0, float, diagonals);
READ_STORED(1, FairScalars, scalars);

// Of the largest: control points without lines stay where they are.
const float kLeastDiagonal = 1e-14;

void main() {
  float least = kLeastDiagonal * uintBitsToFloat(scalars[0].largest_bits);
  FOR_ELEMENTS(v) diagonals[v] = diagonals[v] > 0.0 ? 1.0 / max(diagonals[v], least) : 0.0;
}
