#pragma once

#include <cstdint>

#include "planish/surface/surface_mesh.h"

namespace planish {

/// Triangles whose normals differ by more than an angle from corner to corner.
struct TriangleTurns {
  std::int64_t count = 0, first = -1;
  std::int64_t worst = -1;  ///< the first that turns by the most
  double largest = 0;       ///< by that, degrees
};

/// Of a mesh of triangles, by `degrees` and what float32 normals lose. The same for every thread
/// count.
[[nodiscard]] TriangleTurns turns_beyond(const SurfaceMesh& surface, double degrees);

}  // namespace planish
