// What the direction of descent, turned by what the last step found, does to the two lines through
// every control point, and from the square sum of it the length of the step.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

READ(0, FairLinks, links)
READ(1, vec4, rows1)
READ(2, vec4, rows2)
READ(3, vec4, motions)
UPDATE(4, FairScalars, scalars);
WRITE(5, vec2, lines);
UPDATE_TOGETHER(6, float, partials);

#include "fair_motion.glsl"
#include "fair_total.glsl"

// The residual's square by the curvature along the direction.
void write_step_length(float curvature) {
  if (parameters.start != 0u) {
    scalars[0].step = 1.0;
    return;
  }
  float square = scalars[0].square;
  // No step once it has converged, or where numbers have left single precision.
  float step = square > scalars[0].enough && curvature > 0.0 ? square / curvature : 0.0;
  scalars[0].step = is_finite(step) ? step : 0.0;
}

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
  if (is_total(sum)) write_step_length(sum);
}
