#version 450
// Satin clay, or colours by error, under a key light, a fill light from the other side and a room
// that is brighter above.
#extension GL_GOOGLE_include_directive : require
#include "draw.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float error;
layout(location = 0) out vec4 colour;

vec3 linear(vec3 srgb) { return pow(srgb, vec3(2.2)); }

vec3 heat_colour(float relative_error) {
  float decade = log(max(relative_error, 1e-30)) / log(10.0);
  float place = clamp((decade - kHeatLowest) / (kHeatHighest - kHeatLowest), 0.0, 1.0) *
                float(kHeatStopCount - 1u);
  uint below = min(uint(place), kHeatStopCount - 2u);
  return linear(mix(kHeatStops[below], kHeatStops[below + 1u], place - float(below)));
}

void main() {
  vec3 n = normalize(normal);
  if (!gl_FrontFacing) n = -n;
  vec3 to_eye = normalize(draw.eye - position);
  vec3 fill = normalize(vec3(-draw.key.x, 0.25, -draw.key.z) + to_eye);
  vec3 room = mix(vec3(0.10, 0.09, 0.09), vec3(0.24, 0.27, 0.32), 0.5 + 0.5 * n.y);
  vec3 light = room + vec3(0.86, 0.82, 0.75) * max(dot(n, draw.key), 0.0) +
               vec3(0.13, 0.16, 0.20) * max(dot(n, fill), 0.0);
  if (draw.heat != 0u) {
    // Flatter, so that the legend's colours are met.
    colour = vec4(displayed(heat_colour(error / draw.diagonal) * mix(vec3(1.0), light, 0.5)), 1.0);
    return;
  }
  vec3 clay = linear(gl_FrontFacing ? vec3(0.82, 0.80, 0.77) : vec3(0.75, 0.60, 0.52));
  float shine = 0.22 * pow(max(dot(n, normalize(draw.key + to_eye)), 0.0), 48.0);
  float rim = 0.14 * pow(1.0 - max(dot(n, to_eye), 0.0), 4.0);
  colour = vec4(displayed(clay * light + vec3(shine + rim)), 1.0);
}
