#pragma once

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_mesh.h"
#include "quality/truth.h"

namespace planish::quality {

/// How the facets that a file holds follow a shape, by area. Lengths are in the mesh's unit, angles
/// in degrees.
struct FacetFigures {
  std::int64_t facets = 0;
  /// Of each facet's normal and centre, root of the mean square.
  double normals = 0, distance = 0;
  double folded = 0;   ///< share of the area that turns by more than 90 degrees from the shape
  double turning = 0;  ///< share of the edges' length at which facets turn by more than 5 degrees
};

/// Of a mesh of triangles.
[[nodiscard]] FacetFigures facet_figures(const PolygonMesh& triangles, const Truth& truth);

/// A surface's faces cut into triangles, as files hold them.
[[nodiscard]] PolygonMesh facets_of(const SurfaceMesh& surface);

}  // namespace planish::quality
