// The levels of the instances of a mesh in a view: which each needs, and its place among their vertices.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "surface/finite.glsl"
#include "shared.h"
#include "read.glsl"

layout(local_size_x = 64) in;

#ifdef KERNEL_choose_levels
// Which level each instance of a mesh needs in a view, by the sphere around its control points,
// which its surface does not leave; kNone where that is not seen. A work group an instance.

const uint kSphereLanes = 64u;
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
#endif

#ifdef KERNEL_place_instances
// Gives each instance that is seen a place among the vertices of its level, or of a coarser one
// where that has none left, in the order of the instances; lists them, and says how often each list
// is walked and what is drawn. One work group.

const uint kPlaceLanes = 64u;
layout(push_constant) uniform Parameters { PlaceInstancesParameters parameters; };

// The levels that are wanted, then those that there was room for.
layout(std430, set = 0, binding = 0) restrict buffer Levels { uint levels[]; };
layout(std430, set = 0, binding = 1) restrict buffer Work { uint work[]; };
layout(std430, set = 0, binding = 2) restrict writeonly buffer Draws { uint draws[]; };

shared uint counts[kPlaceLanes], listed[kMostLevels];
uint lane, total;

// What the lanes before have together; `total`: all of them.
uint sum_before(uint own) {
  barrier();
  counts[lane] = own;
  barrier();
  uint before = 0u;
  total = 0u;
  for (uint i = 0u; i < kPlaceLanes; ++i) {
    if (i < lane) before += counts[i];
    total += counts[i];
  }
  return before;
}

void draw(uint number, uint level, uint count, uint first_vertex, uint first_instance) {
  uint head = level * kLevelWords, at = number * kDrawWords;
  draws[at] = work[head + kLevelIndices];
  draws[at + 1u] = count;
  draws[at + 2u] = work[head + kLevelFirstIndex];
  draws[at + 3u] = first_vertex;
  draws[at + 4u] = parameters.numbers_draws != 0u ? first_instance : 0u;
}

void main() {
  lane = gl_LocalInvocationIndex;
  uint count = parameters.instance_count;
  uint share = (count + kPlaceLanes - 1u) / kPlaceLanes;
  uint begin = min(lane * share, count), end = min(begin + share, count);
  uint segments = parameters.level_count * kLevelWords;
  uint seen_list = segments + parameters.segment_count * kChosenWords;
  uint seen = 0u;
  for (uint i = begin; i < end; ++i) {
    uint level = levels[i];
    levels[count + i] = level;
    if (level != kNone) {
      ++seen;
    } else {
      for (uint k = 0u; k < kDrawWords; ++k) draws[i * kDrawWords + k] = 0u;
    }
  }
  uint at = seen_list + sum_before(seen);
  uint all_seen = total;
  for (uint i = begin; i < end; ++i)
    if (levels[i] != kNone) work[at++] = i;
  // From fine to coarse; the coarsest has room for all.
  for (uint level = parameters.level_count; level-- > 0u;) {
    uint own = 0u;
    for (uint i = begin; i < end; ++i) own += levels[count + i] == level ? 1u : 0u;
    uint place = sum_before(own);
    uint head = level * kLevelWords;
    uint places = work[head + kLevelPlaces], list = work[head + kLevelList];
    uint first_row = work[head + kLevelFirstRow];
    for (uint i = begin; i < end; ++i) {
      if (levels[count + i] != level) continue;
      if (place < places) {
        uint vertex = work[head + kLevelFirstVertex] + place * work[head + kLevelVertices];
        work[list + kDrawnWords * place] = i;
        work[list + kDrawnWords * place + 1u] = vertex - first_row;
        draw(i, level, 1u, vertex, i);
      } else {
        levels[count + i] = level - 1u;
      }
      ++place;
    }
    if (lane == 0u) {
      listed[level] = min(total, places);
      draw(count + level, level, listed[level], first_row,
           (list - work[kLevelList]) / kDrawnWords);
    }
  }
  barrier();
  for (uint s = lane; s < parameters.segment_count; s += kPlaceLanes) {
    uint segment = segments + s * kChosenWords;
    uint level = work[segment + kChosenLevel];
    work[segment + 1u] = level == kNone ? all_seen : listed[level];
  }
}
#endif
