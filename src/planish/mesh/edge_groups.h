#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Elements 0 to count - 1 in sets that can only be united (union-find with path halving).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  [[nodiscard]] std::int32_t find(std::int32_t element) {
    while (parents_[element] != element) {
      parents_[element] = parents_[parents_[element]];
      element = parents_[element];
    }
    return element;
  }

  /// False when both were in one set already.
  bool unite(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a == b) return false;
    parents_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::vector<std::int32_t> parents_;
};

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

/// A half-edge is numbered 3 * triangle + corner: it runs from that corner to the next.
[[nodiscard]] constexpr std::int32_t next_half_edge(std::int32_t half_edge) {
  return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}
[[nodiscard]] constexpr std::int32_t previous_half_edge(std::int32_t half_edge) {
  return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1;
}

/// The sides of triangles grouped by edge; FaceSide::corner is the half-edge.
[[nodiscard]] EdgeGroups edges_of(std::span<const Triangle> triangles, std::size_t vertex_count);

/// The half-edge on the other side of each, -1 on the boundary. No edge may have more than two
/// triangles.
[[nodiscard]] std::vector<std::int32_t> twins_of(std::span<const Triangle> triangles,
                                                 std::size_t vertex_count);

/// Quads, four corners each, cut from their first corner to their third.
[[nodiscard]] std::vector<Triangle> quads_as_triangles(std::span<const std::int32_t> corners);

/// The triangles as polygons; positions are left empty.
[[nodiscard]] PolygonMesh polygons_of(std::span<const Triangle> triangles);

}  // namespace planish
