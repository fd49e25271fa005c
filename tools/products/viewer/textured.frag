#version 450
// A board of squares by texture coordinates, redder along u and bluer along v.
#extension GL_GOOGLE_include_directive : require
#include "shade.glsl"

layout(location = 3) in vec2 uv;

// Of the squares that are light, what a pixel sees: the mean over it of both directions' waves.
float light_share(vec2 place) {
  vec2 width = max(fwidth(place), vec2(1e-4));
  vec2 begin = place - 0.5 * width, end = place + 0.5 * width;
  vec2 wave = 2.0 * (abs(fract(0.5 * end) - 0.5) - abs(fract(0.5 * begin) - 0.5)) / width;
  return 0.5 - 0.5 * wave.x * wave.y;
}

void main() {
  vec2 along = clamp(uv, 0.0, 1.0);
  vec3 dark = vec3(0.20 + 0.60 * along.x, 0.30, 0.20 + 0.60 * along.y);
  colour = satin(linear(mix(dark, vec3(0.86), light_share(kBoardSquares * uv))));
}
