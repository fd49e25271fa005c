#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// One side of a face, running from its corner to the face's next corner.
struct FaceSide {
  std::int32_t higher;  ///< the greater of its two vertices
  std::int32_t corner;  ///< index into face_vertices of the vertex it starts at
  std::int32_t face;
};

/// The sides of a mesh's faces, grouped by undirected edge in linear time.
struct EdgeGroups {
  std::vector<std::int32_t> offsets;  ///< by the lower vertex of an edge; vertex_count + 1
  std::vector<FaceSide> sides;        ///< within a lower vertex sorted by (higher, corner)

  /// All sides on the edge between two vertices, in any order of the two; empty if it is none.
  [[nodiscard]] std::span<const FaceSide> find(std::int32_t v0, std::int32_t v1) const;

  /// Calls visit(lower vertex, sides of one edge) for every edge.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t lower = 0; lower + 1 < offsets.size(); ++lower) {
      for (std::int32_t begin = offsets[lower], end; begin < offsets[lower + 1]; begin = end) {
        end = begin + 1;
        while (end < offsets[lower + 1] && sides[end].higher == sides[begin].higher) ++end;
        visit(static_cast<std::int32_t>(lower),
              std::span<const FaceSide>(sides).subspan(begin, end - begin));
      }
    }
  }
};

/// Groups the sides of all faces f with use_face[f] != 0. These faces must have at least two
/// corners, valid offsets and indices in range.
[[nodiscard]] EdgeGroups group_edges(const PolygonMesh& mesh,
                                     std::span<const std::uint8_t> use_face);
/// The same of all faces.
[[nodiscard]] EdgeGroups group_edges(const PolygonMesh& mesh);

/// The corner after `corner` in `face`, going round.
[[nodiscard]] inline std::int32_t next_corner(const PolygonMesh& mesh, std::int32_t face,
                                              std::int32_t corner) {
  return corner + 1 == mesh.face_offsets[face + 1] ? mesh.face_offsets[face] : corner + 1;
}

}  // namespace planish
