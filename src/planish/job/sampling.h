#pragma once

#include <cstdint>

#include "planish/core/callbacks.h"
#include "planish/mesh/point_cloud.h"

namespace planish {

struct Input;  // input.h

/// Points that stand in for a mesh: drawn from the interpolating surface through its vertices, by
/// area.
struct Sampling {
  std::int64_t points = 0;
  bool poisson_disk = true;  ///< no two near each other; else independent
  std::uint32_t seed = 1;
  double noise = 0;     ///< standard deviation along each axis, of the diagonal
  double outliers = 0;  ///< further points, even in the bounding box, as a part of `points`
  /// What draws them: the same points for the same mesh and sampling.
  PointCloud (*draw)(const Input& mesh, const Sampling& sampling,
                     const Callbacks& callbacks) = nullptr;
};

}  // namespace planish
