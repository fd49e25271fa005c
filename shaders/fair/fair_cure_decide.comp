// Counts one round more at every flagged vertex, or takes the rounds that were decided, and notes what is
// to be done: a perpendicular polygon in the first round, a quarter of it in every other.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "fair.glsl"

UPDATE(0, uint, flags);
UPDATE(1, uint, decisions);
UPDATE(2, uint, counts);

void main() {
  FOR_ELEMENTS(v) {
    uint cures = decisions[v] >> kCureShift;
    if (parameters.decided != 0u) {
      flags[v] = cures == 0u ? 0u : kChanged | kRebuild | (cures - 1u) << kQuartersShift;
    } else if ((flags[v] & kBad) != 0u) {
      flags[v] = kChanged | (cures == 0u ? kRebuild : 1u << kQuartersShift);
      decisions[v] += 1u << kCureShift;
      atomicAdd(counts[parameters.place], 1u);
    } else {
      flags[v] = 0u;
    }
  }
}
