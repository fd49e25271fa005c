// Which level each instance of a mesh needs in a view, by the sphere around its control points,
// which its surface does not leave; kNone where that is not seen. A work group an instance.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "surface/finite.glsl"
#include "shared.h"
#include "read.glsl"

const uint kSphereLanes = 64u;
layout(local_size_x = 64) in;
layout(push_constant) uniform Parameters { ChooseParameters parameters; };

READ(0, vec4, points)
// Each instance's level of the last view, then as many of which place_instances tells.
layout(std430, set = 0, binding = 1) restrict buffer Levels { uint levels[]; };

shared vec3 lows[kSphereLanes], highs[kSphereLanes];
shared float radii[kSphereLanes];

vec3 centre_of(uint first, uint lane) {
  vec3 low = points_at(first).xyz, high = low;
  for (uint i = lane; i < parameters.point_count; i += kSphereLanes) {
    vec3 point = points_at(first + i).xyz;
    low = min(low, point);
    high = max(high, point);
  }
  lows[lane] = low, highs[lane] = high;
  for (uint count = kSphereLanes / 2u; count > 0u; count /= 2u) {
    barrier();
    if (lane < count) {
      lows[lane] = min(lows[lane], lows[lane + count]);
      highs[lane] = max(highs[lane], highs[lane + count]);
    }
  }
  barrier();
  return 0.5 * lows[0] + 0.5 * highs[0];
}

float radius_of(uint first, uint lane, vec3 centre) {
  float radius = 0.0;
  for (uint i = lane; i < parameters.point_count; i += kSphereLanes)
    radius = max(radius, distance(points_at(first + i).xyz, centre));
  radii[lane] = radius;
  for (uint count = kSphereLanes / 2u; count > 0u; count /= 2u) {
    barrier();
    if (lane < count) radii[lane] = max(radii[lane], radii[lane + count]);
  }
  barrier();
  return radii[0];
}

// A row of the matrix.
vec4 row(uint i) {
  return vec4(parameters.clip[i], parameters.clip[4u + i], parameters.clip[8u + i],
              parameters.clip[12u + i]);
}
bool is_beyond(vec4 plane, vec3 centre, float radius) {
  return dot(plane.xyz, centre) + plane.w < -radius * length(plane.xyz);
}

uint level_of(vec3 centre, float radius, uint last) {
  vec4 x = row(0u), y = row(1u), z = row(2u), w = row(3u);
  if (!is_finite(radius) || !is_finite(dot(centre, centre))) return kNone;
  if (is_beyond(w + x, centre, radius) || is_beyond(w - x, centre, radius) ||
      is_beyond(w + y, centre, radius) || is_beyond(w - y, centre, radius) ||
      is_beyond(z, centre, radius) || is_beyond(w - z, centre, radius))
    return kNone;
  // How near its nearest point is; none is far from the surface where the eye is within the sphere.
  float depth = dot(w.xyz, centre) + w.w - radius * length(w.xyz);
  float size = radius * length(y.xyz) * parameters.pixels;
  uint level = 0u;
  while (level + 1u < parameters.level_count &&
         !(size * parameters.chords[level] <= parameters.most * depth))
    ++level;
  // The last one stays until a coarser one is well enough.
  if (last >= parameters.level_count) return level;
  while (level < last && !(size * parameters.chords[level] <= parameters.coarser_at * depth))
    ++level;
  return level;
}

void main() {
  uint lane = gl_LocalInvocationIndex;
  for (uint i = gl_WorkGroupID.x; i < parameters.instance_count; i += gl_NumWorkGroups.x) {
    uint first = i * parameters.point_stride;
    vec3 centre = centre_of(first, lane);
    float radius = radius_of(first, lane, centre);
    if (lane == 0u) levels[i] = level_of(centre, radius, levels[i]);
    barrier();
  }
}
