// What the direction of descent does to the two lines through every control point, and the square
// sum of it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairLinks, links)
READ(1, vec4, rows1)
READ(2, vec4, rows2)
READ(3, float, direction)
WRITE(4, vec2, lines);
WRITE(5, float, partials);

#include "fair_sum.glsl"

void main() {
  float sum = 0.0;
  FOR_ELEMENTS(c) {
    FairLinks corner = links_at(c);
    vec4 row1 = rows1_at(c), row2 = rows2_at(c);
    vec2 line = vec2(row1.w, row2.w);  // at height 0
    if (parameters.start == 0u) {
      float own = direction_at(c);
      line = vec2(row1.x * direction_at(corner.next) + row1.y * own +
                      row1.z * direction_at(corner.after),
                  row2.x * direction_at(corner.previous) + row2.y * own +
                      row2.z * direction_at(corner.before));
    }
    lines[c] = line;
    sum += dot(line, line);
  }
  sum = group_sum(sum);
  if (gl_LocalInvocationIndex == 0u) partials[gl_WorkGroupID.x] = sum;
}
