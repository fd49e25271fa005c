// What the direction of descent, turned by what the last step found, does to the two lines through
// every control point, and the square sum of it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairLinks, links)
READ(1, vec4, rows1)
READ(2, vec4, rows2)
READ(3, vec4, motions)
READ_STORED(4, FairScalars, scalars);
WRITE(5, vec2, lines);
WRITE(6, float, partials);

#include "fair_motion.glsl"
#include "group_fold.glsl"

void main() {
  float sum = 0.0;
  float momentum = scalars[0].momentum;
  FOR_ELEMENTS(c) {
    vec4 row1 = rows1_at(c), row2 = rows2_at(c);
    vec2 line = vec2(row1.w, row2.w);  // at height 0
    if (parameters.start == 0u) {
      FairLinks corner = links_at(c);
      float own = turned(motions_at(c), momentum);
      line = vec2(row1.x * turned(motions_at(corner.next), momentum) + row1.y * own +
                      row1.z * turned(motions_at(corner.after), momentum),
                  row2.x * turned(motions_at(corner.previous), momentum) + row2.y * own +
                      row2.z * turned(motions_at(corner.before), momentum));
    }
    lines[c] = line;
    sum += dot(line, line);
  }
  sum = group_sum(sum);
  if (gl_LocalInvocationIndex == 0u) partials[gl_WorkGroupID.x] = sum;
}
