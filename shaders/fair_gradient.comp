// Half the gradient of the bending along the lines' change, for every control point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairCorner, corners);
READ(1, vec4, rows1);
READ(2, vec4, rows2);
READ(3, vec2, lines);
WRITE(4, float, gradient);

void main() {
  FOR_ELEMENTS(c) {
    FairCorner corner = corners[c];
    float sum = rows1[c].y * lines[c].x + rows2[c].y * lines[c].y +
                rows1[corner.previous].x * lines[corner.previous].x +
                rows2[corner.next].x * lines[corner.next].y;
    // Beyond the corners stand curve points, which have no lines.
    if (corner.before < parameters.count)
      sum += rows1[corner.before].z * lines[corner.before].x;
    if (corner.after < parameters.count) sum += rows2[corner.after].z * lines[corner.after].y;
    gradient[c] = sum;
  }
}
