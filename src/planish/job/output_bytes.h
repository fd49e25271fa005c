#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "planish/job/job_settings.h"
#include "planish/job/output_plan.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/stencil/level_counts.h"

namespace planish {

/// What of a mesh decides how many rows, vertices and bytes its surface is written as.
struct WrittenShape {
  bool has_uvs = false, has_colors = false;
  bool has_uv_seams = false;  ///< or corners without coordinates
  std::int64_t group_count = 0;
  std::uint64_t name_bytes = 0;  ///< of groups and materials
  std::size_t largest_face = 0;
  std::int64_t corner_count = 0;   ///< of level 0
  std::size_t property_count = 0;  ///< of vertices, that surfaces carry

  /// Copies of a mesh's vertices, and edges whose inner vertices are copied at every level.
  struct Copies {
    std::int64_t vertices = 0, edges = 0;

    [[nodiscard]] std::int64_t at(int level) const {
      return vertices + edges * ((std::int64_t{1} << level) - 1);
    }
  };
  Copies rows;           ///< where the surface has several normals
  Copies gltf_vertices;  ///< further ones for groups and texture coordinates
};

/// `prepared` is of `mesh`.
[[nodiscard]] WrittenShape written_shape(const PolygonMesh& mesh, const PreparedMesh& prepared);

/// One level of it.
struct WrittenLevel {
  int level = 0;
  LevelCounts counts{};       ///< without copies
  bool is_triangles = false;  ///< of Loop
};

/// How many vertices the file has, copies of groups and texture coordinates apart.
[[nodiscard]] std::int64_t written_vertices(const WrittenShape& shape, const WrittenLevel& level,
                                            OutputKind kind);

/// How many bytes the file takes, with its companions: glTF, PLY and STL to some hundred bytes of
/// header; of packed glTF an upper estimate; nothing of text and of tiles.
[[nodiscard]] std::optional<std::uint64_t> output_bytes(const WrittenShape& shape,
                                                        const WrittenLevel& level,
                                                        const PlannedOutput& output,
                                                        const Settings& settings);

}  // namespace planish
