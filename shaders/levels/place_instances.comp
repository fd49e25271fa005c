// Gives each instance that is seen a place among the vertices of its level, or of a coarser one
// where that has none left, in the order of the instances; lists them, and says how often each list
// is walked and what is drawn. One work group.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared.h"

const uint kPlaceLanes = 64u;
layout(local_size_x = 64) in;
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

void draw(uint instance, uint level, uint place) {
  uint head = level * kLevelWords, at = instance * kDrawWords;
  draws[at] = work[head + kLevelIndices];
  draws[at + 1u] = 1u;
  draws[at + 2u] = work[head + kLevelFirstIndex];
  draws[at + 3u] = work[head + kLevelFirstVertex] + place * work[head + kLevelVertices];
  draws[at + 4u] = parameters.numbers_draws != 0u ? instance : 0u;
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
    for (uint i = begin; i < end; ++i) {
      if (levels[count + i] != level) continue;
      if (place < places) {
        work[list + place] = i;
        draw(i, level, place);
      } else {
        levels[count + i] = level - 1u;
      }
      ++place;
    }
    if (lane == 0u) listed[level] = min(total, places);
  }
  barrier();
  for (uint s = lane; s < parameters.segment_count; s += kPlaceLanes) {
    uint segment = segments + s * kChosenWords;
    uint level = work[segment + kChosenLevel];
    work[segment + 1u] = level == kNone ? all_seen : listed[level];
  }
}
