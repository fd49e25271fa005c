#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Faces of one group: a primitive of the file.
struct GltfPart {
  std::int32_t group = -1;  ///< -1: the surface has no groups
  std::int64_t first_vertex = 0, vertex_count = 0;
  int uv_sets = 0;  ///< sets of texture coordinates
  std::uint64_t face_count = 0, triangle_count = 0;
  std::vector<RowRange> faces;  ///< ascending
};

/// A corner of the surface that has not its row's first vertex.
struct SeamCorner {
  std::int64_t corner;
  std::int32_t vertex;
};

/// A surface as glTF has it: one texture coordinate a vertex, and vertices of its own for each
/// primitive, since readers that count by primitive would hold shared ones again and again.
struct GltfVertices {
  std::int64_t kept_rows = 0;      ///< so many of the surface's rows are the first vertices
  std::vector<std::int32_t> rows;  ///< the surface's row of each vertex behind those
  std::vector<std::int32_t>
      uvs;  ///< texture coordinate of each vertex; empty: none; -1: none there
  RawVector<std::int32_t> corners;  ///< vertex of each corner in its primitive; empty: its row,
  std::vector<SeamCorner> seams;    ///< but for these, ascending
  std::vector<GltfPart> parts;      ///< one for each group that has faces, at least one

  [[nodiscard]] std::int64_t count() const {
    return kept_rows + static_cast<std::int64_t>(rows.size());
  }
  [[nodiscard]] std::int64_t row_of(std::int64_t vertex) const {
    return vertex < kept_rows ? vertex : rows[vertex - kept_rows];
  }
};

/// Splits vertices along the seams of the texture coordinates and between primitives. Of one
/// primitive the surface's rows stay the first vertices, in their order: each takes the texture
/// coordinate of its first corner, every other gets a vertex of its own behind them. Several have
/// each the rows of its faces, in their order, and such copies behind them. Sets of texture
/// coordinates are as the options say.
[[nodiscard]] GltfVertices gltf_vertices(const SurfaceBlocks& surface, const GltfOptions& options);

/// A vertex behind the kept rows, by its row: sorted by row, then by vertex.
struct CopiedRow {
  std::int32_t row;
  std::int64_t vertex;
  [[nodiscard]] bool operator<(const CopiedRow& other) const {
    return row != other.row ? row < other.row : vertex < other.vertex;
  }
};
[[nodiscard]] std::vector<CopiedRow> copied_rows(const GltfVertices& vertices);
/// Those of a range of rows, out of all copies.
[[nodiscard]] std::span<const CopiedRow> copies_in(std::span<const CopiedRow> copied,
                                                   RowRange range);

}  // namespace planish
