#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/distributed/messages.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// What rides on a slice of a mesh, as PolygonMesh has it of a whole one. The flags are the same on
/// all ranks; where one is not set, what it names is empty.
struct SliceAttributes {
  bool has_colors = false, has_uvs = false, has_groups = false;
  std::vector<glm::vec4> colors;          ///< linear RGBA, one per vertex of the slice
  Layout uv_runs;                         ///< the runs of all ranks of the texture coordinates
  std::vector<glm::dvec2> uvs;            ///< those of this rank's run
  std::vector<std::int64_t> face_uvs;     ///< one per corner: a number in the file; -1: none there
  std::vector<FaceGroup> groups;          ///< of the whole mesh, the same on all ranks
  std::vector<std::int32_t> face_groups;  ///< one per face of the slice
};

/// The texts of rank 0, then those of rank 1, ..., on all ranks.
[[nodiscard]] std::vector<std::string> texts_of_all(const Ranks& ranks,
                                                    std::span<const std::string> own);

/// Gives faces their groups: those of all ranks in the order of their first faces, as one reader
/// numbers them; none where no group has a name. `own`: this rank's groups in that order,
/// `face_groups` name one of them for each of its faces.
void settle_groups(const Ranks& ranks, std::span<const FaceGroup> own,
                   std::vector<std::int32_t> face_groups, SliceAttributes& attributes);

/// The slices of what rides on a mesh that rank 0 has, whose vertices, faces and corners go to
/// ranks by these counts (rank 0's; others' are not looked at).
struct ScatterCounts {
  std::span<const std::int64_t> vertices, faces, corners;
};
[[nodiscard]] SliceAttributes scatter_attributes(const Ranks& ranks, const PolygonMesh& mesh,
                                                 const ScatterCounts& counts);

}  // namespace planish
