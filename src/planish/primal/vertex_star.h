#pragma once

#include <cstdint>
#include <vector>

#include "planish/primal/primal_split.h"

namespace planish {

/// A vertex with the edges and faces around it, counter-clockwise, at a boundary from the first to
/// the last edge. Face i lies between edges i and i + 1.
struct VertexStar {
  std::int32_t vertex = 0;
  float sharpness = 0;
  std::vector<std::int32_t> edge_ends;  ///< the edges' other vertices
  std::vector<float> edge_sharpness;
  /// Catmull-Clark where every face is a quad: its corner opposite to the vertex; else empty.
  std::vector<std::int32_t> face_ends;
  std::int32_t face_count = 0;

  [[nodiscard]] std::int32_t edge_count() const {
    return static_cast<std::int32_t>(edge_ends.size());
  }
  [[nodiscard]] bool is_boundary() const { return face_count < edge_count(); }
};

/// The star of a vertex of M_level, with `face_ends` from level 1 on. Reuse `star` to avoid
/// allocation.
void gather_star(const PrimalSplit& split, int level, std::int32_t vertex, VertexStar& star);

// Sectors: the faces between two edges of infinite sharpness, which part the normals.

/// 1 where there are fewer than two such edges.
[[nodiscard]] std::int32_t sector_count(const VertexStar& star);
/// The sector that holds the star's face `face`.
[[nodiscard]] std::int32_t sector_of(const VertexStar& star, std::int32_t face);

/// A sector's faces.
struct Sector {
  std::int32_t first_edge, face_count;
};
/// For stars of at least two sectors and for boundaries.
[[nodiscard]] Sector sector(const VertexStar& star, std::int32_t index);

}  // namespace planish
