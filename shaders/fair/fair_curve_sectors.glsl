// The sectors between curve points at a vertex. The including kernel declares places and links.
#include "fair_walk.glsl"
struct CurveSector {
  uint first, count;    // places
  uint curve0, curve1;  // points of the state before and after it
};

// The last place of that sector, looked for by all lanes at once.
uint last_shared(uint first, uint end) {
  for (; first < end; first += kGroupLanes) {
    uint place = first + gl_LocalInvocationIndex;
    bool is_last = place < end && links_at(places_at(place).corner).after >= parameters.corner_count;
    float least = group_min(float(is_last ? gl_LocalInvocationIndex : kGroupLanes));
    if (least < float(kGroupLanes)) return first + uint(least);
  }
  return end - 1u;
}

// The sector that begins at a place before `end`; false beside a cone, around which there is none.
bool sector_from(uint first, uint end, out CurveSector sector) {
  uint last = kShared ? last_shared(first, end) : first;
  uint after = links_at(places_at(last).corner).after;
  while (!kShared && last + 1u < end && after < parameters.corner_count) {
    ++last;
    after = links_at(places_at(last).corner).after;
  }
  uint before = links_at(places_at(first).corner).before;
  sector = CurveSector(first, last + 1u - first, before, after);
  return before >= parameters.corner_count && after >= parameters.corner_count;
}
