// Declarations that the drawing shaders share.
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

layout(push_constant) uniform Push { DrawParameters draw; };

// The light leaves darks and mid tones alone and bends what is brighter towards 1; then sRGB, by a
// power of 2.2.
vec3 displayed(vec3 light) {
  const float start = 0.6;
  vec3 bent = start + (1.0 - start) * (1.0 - exp((start - light) / (1.0 - start)));
  vec3 shoulder = mix(light, bent, greaterThan(light, vec3(start)));
  return pow(clamp(shoulder, 0.0, 1.0), vec3(1.0 / 2.2));
}
