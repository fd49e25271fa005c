// Half the gradient of the bending along the lines' change, for every control point.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairLinks, links)
READ(1, vec4, rows1)
READ(2, vec4, rows2)
READ(3, vec2, lines)
WRITE(4, float, gradient);

void main() {
  FOR_ELEMENTS(c) {
    FairLinks corner = links_at(c);
    float sum = rows1_at(c).y * lines_at(c).x + rows2_at(c).y * lines_at(c).y +
                rows1_at(corner.previous).x * lines_at(corner.previous).x +
                rows2_at(corner.next).x * lines_at(corner.next).y;
    // Beyond the corners stand curve points, which have no lines.
    if (corner.before < parameters.count)
      sum += rows1_at(corner.before).z * lines_at(corner.before).x;
    if (corner.after < parameters.count) sum += rows2_at(corner.after).z * lines_at(corner.after).y;
    gradient[c] = sum;
  }
}
