// The curve at a crease or boundary vertex; fair/crease_handle.h.

// A quarter of the two sharp edges.
struct CreaseArms {
  vec3 before, after;
};

float arm_imbalance(CreaseArms arms) {
  float before = safe_length(arms.before), after = safe_length(arms.after);
  float shorter = min(before, after);
  return shorter > 0.0 ? abs(before - after) / shorter : uintBitsToFloat(0x7f800000u);
}
