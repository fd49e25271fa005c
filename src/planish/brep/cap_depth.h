#pragma once

#include <cstdint>
#include <vector>

#include "planish/brep/quad_layout.h"
#include "planish/core/callbacks.h"

namespace planish {

constexpr int kDeepestCap = 12;

struct CapLimits {
  double angle = 0.25;      ///< degrees between normals across an edge
  double deviation = 1e-6;  ///< along the normal, of the diagonal
};

/// How far the squares at extraordinary points are halved, and what that reaches.
struct CapDepths {
  std::vector<std::int8_t> of_vertex;  ///< by vertex of Q_1; 1 where nothing is to be halved
  std::int64_t count = 0;
  int deepest = 0;
  double max_angle = 0, max_deviation = 0;
};

/// The smallest depths, to kDeepestCap, that keep the limits; each place by itself. Reports step
/// "faces" from 0 to 1.
[[nodiscard]] CapDepths cap_depths(const LimitSurface& surface, const QuadLayout& layout,
                                   const CapLimits& limits, const Callbacks& callbacks);

}  // namespace planish
