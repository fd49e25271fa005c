#version 450
// Satin clay, or colours by error.
#extension GL_GOOGLE_include_directive : require
#include "shade.glsl"

layout(location = 2) in float error;

vec3 heat_colour(float relative_error) {
  float decade = log(max(relative_error, 1e-30)) / log(10.0);
  float place = clamp((decade - kHeatLowest) / (kHeatHighest - kHeatLowest), 0.0, 1.0) *
                float(kHeatStopCount - 1u);
  uint below = min(uint(place), kHeatStopCount - 2u);
  return linear(mix(kHeatStops[below], kHeatStops[below + 1u], place - float(below)));
}

void main() {
  if (draw.heat != 0u) {
    // Flatter, so that the legend's colours are met.
    vec3 light = mix(vec3(1.0), light_on(seen_normal()), 0.5);
    colour = vec4(displayed(heat_colour(error / draw.diagonal) * light), 1.0);
    return;
  }
  colour = satin(linear(gl_FrontFacing ? vec3(0.82, 0.80, 0.77) : vec3(0.75, 0.60, 0.52)));
}
