#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/mesh/hole_flags.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_numbering.h"

namespace planish::vulkan {

/// The corners of the output's faces, face by face, without those of hole faces; calls take(corners
/// of a face).
template <class Take>
void for_kept_faces(const PolygonMesh& mesh, const MeshTopology& topology,
                    const PatchNumbering& numbering, const Take& take) {
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  const PatchCells cells(std::max(numbering.level(), 1));
  const std::int32_t side = numbering.samples().side() + 1;
  std::vector<std::int32_t> corners, grid(static_cast<std::size_t>(side * side));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f] != 0) continue;
    const std::int32_t first = topology.first_corner(f), end = first + topology.face_size(f);
    if (numbering.level() == 0) {
      corners.clear();
      for (std::int32_t c = first; c < end; ++c) corners.push_back(numbering.vertex_row(c));
      take(std::span<const std::int32_t>(corners));
      continue;
    }
    for (std::int32_t c = first; c < end; ++c) {
      numbering.grid(c, grid.data());
      for (const auto& cell : cells.of(topology, c)) {
        corners = {grid[cell[0]], grid[cell[1]], grid[cell[2]], grid[cell[3]]};
        take(std::span<const std::int32_t>(corners));
      }
    }
  }
}

/// Appends the triangles of a face, a fan from its first corner.
inline void add_triangles(std::span<const std::int32_t> corners,
                          std::vector<std::uint32_t>& triangles) {
  for (std::size_t k = 2; k < corners.size(); ++k)
    for (const std::int32_t vertex : {corners[0], corners[k - 1], corners[k]})
      triangles.push_back(static_cast<std::uint32_t>(vertex));
}

}  // namespace planish::vulkan
