#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/analytic/region_borders.h"
#include "planish/brep/brep.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// The mesh that was fitted, beside the one that it was made of, some of whose triangles it may
/// have joined, and to which it may have added vertices.
struct FittedTopology {
  const MeshTopology& topology;
  /// By vertex, vertices of the given mesh: {v, v}: it is that one; {a, b}: it lies on the edge
  /// between these; {-1, -1}: elsewhere.
  std::span<const std::array<std::int32_t, 2>> on;
};

/// Where the fitted mesh leaves analytic regions for faces of none.
struct FreeBorders {
  /// By chain, along it: corners of the fitted mesh, whose leading edges make it up and which are
  /// on its region's side. Empty where it has no such edges, and of chains between regions.
  std::vector<std::vector<std::int32_t>> corners;
  std::vector<char> is_border;  ///< by edge of the fitted mesh
  std::vector<char> is_free;    ///< by face of the fitted mesh
  /// By face of the fitted mesh: it lies on both sides of a border.
  std::vector<char> is_torn;
};
[[nodiscard]] FreeBorders find_free_borders(const RegionBorders& borders,
                                            const FittedTopology& fitted);

/// A part of a B-spline face's edge, by the edge's parameters; it runs against the edge where
/// `from` is above `to`.
struct FreeSpan {
  std::int32_t edge = -1;
  double from = 0, to = 0;
};

/// By chain, along it, the edges between B-spline faces of both its sides; a closed one may begin
/// at another of its vertices. `brep` is that of the fitted mesh, whose faces end at all borders.
[[nodiscard]] std::vector<std::vector<FreeSpan>> spans_along(const RegionBorders& borders,
                                                             const FreeBorders& free,
                                                             const MeshTopology& fitted,
                                                             const Brep& brep,
                                                             std::span<const char> is_free_face);

/// B-spline faces of degree 2 between those on surfaces.
struct FreeformFaces {
  const Brep& brep;                            ///< of the whole mesh, in model coordinates
  std::span<const std::int32_t> part_of;       ///< by its faces: whose free face it is; -1: of none
  std::vector<std::vector<FreeSpan>> spans{};  ///< by chain of the borders, see spans_along()
};

}  // namespace planish
