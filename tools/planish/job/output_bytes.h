#pragma once

#include <cstddef>
#include <cstdint>

#include "options/settings.h"
#include "output/output_plan.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/stencil/quad_split.h"

namespace planish::command {

/// What of a mesh decides how many rows, vertices and bytes its surface is written as.
struct WrittenShape {
  bool has_uvs = false, has_colors = false, has_groups = false;
  std::int64_t uv_count = 0;  ///< of level 0
  std::int64_t group_count = 0;
  std::uint64_t name_bytes = 0;  ///< of groups and materials
  std::size_t largest_face = 0;
  std::int64_t vertex_count = 0, corner_count = 0;  ///< of level 0

  /// Copies of a mesh's vertices, and edges whose inner vertices are copied at every level.
  struct Copies {
    std::int64_t vertices = 0, edges = 0;

    [[nodiscard]] std::int64_t at(int level) const {
      return vertices + edges * ((std::int64_t{1} << level) - 1);
    }
  };
  Copies rows;                ///< where the surface has several normals
  Copies gltf_vertices;       ///< further ones for groups and texture coordinates
  std::int64_t uv_seams = 0;  ///< edges that two pairs of texture coordinates belong to
};

/// `prepared` is of `mesh`.
[[nodiscard]] WrittenShape written_shape(const PolygonMesh& mesh, const PreparedMesh& prepared);

/// One level of it.
struct WrittenLevel {
  int level = 0;
  LevelCounts counts{};       ///< without copies
  bool is_triangles = false;  ///< of Loop
};

/// About how many bytes the file takes, with its companions: binary formats to some hundred bytes
/// of header; text at the full length of its numbers, a third more where many are round.
[[nodiscard]] std::uint64_t output_bytes(const WrittenShape& shape, const WrittenLevel& level,
                                         const PlannedOutput& output, const Settings& settings);

}  // namespace planish::command
