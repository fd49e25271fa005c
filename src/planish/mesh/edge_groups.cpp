#include "planish/mesh/edge_groups.h"

#include <algorithm>
#include <utility>

#include "planish/core/group_by.h"

namespace planish {
namespace {

// Calls visit(lower, side) for each side of the faces in use.
template <class Visit>
void for_each_side(const PolygonMesh& mesh, std::span<const std::uint8_t> use_face,
                   const Visit& visit) {
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    if (!use_face[face]) continue;
    for (std::int32_t corner = mesh.face_offsets[face]; corner < mesh.face_offsets[face + 1];
         ++corner) {
      const std::int32_t from = mesh.face_vertices[corner];
      const std::int32_t to = mesh.face_vertices[next_corner(mesh, face, corner)];
      visit(std::min(from, to), FaceSide{std::max(from, to), corner, face});
    }
  }
}

}  // namespace

std::span<const FaceSide> EdgeGroups::find(std::int32_t v0, std::int32_t v1) const {
  const std::int32_t lower = std::min(v0, v1), higher = std::max(v0, v1);
  if (lower < 0 || higher >= static_cast<std::int64_t>(offsets.size()) - 1) return {};
  const auto end = sides.begin() + offsets[lower + 1];
  const auto first = std::lower_bound(
      sides.begin() + offsets[lower], end, higher,
      [](const FaceSide& side, std::int32_t vertex) { return side.higher < vertex; });
  const auto last =
      std::find_if(first, end, [&](const FaceSide& side) { return side.higher != higher; });
  return {first, last};
}

EdgeGroups group_edges(const PolygonMesh& mesh, std::span<const std::uint8_t> use_face) {
  auto [offsets, sides] = group_by<FaceSide>(
      mesh.positions.size(), [&](const auto& take) { for_each_side(mesh, use_face, take); });
  EdgeGroups groups{std::move(offsets), std::move(sides)};
  for (std::size_t lower = 0; lower < mesh.positions.size(); ++lower) {
    std::sort(groups.sides.begin() + groups.offsets[lower],
              groups.sides.begin() + groups.offsets[lower + 1],
              [](const FaceSide& a, const FaceSide& b) {
                return a.higher != b.higher ? a.higher < b.higher : a.corner < b.corner;
              });
  }
  return groups;
}

EdgeGroups group_edges(const PolygonMesh& mesh) {
  return group_edges(mesh, std::vector<std::uint8_t>(mesh.face_count(), 1));
}

}  // namespace planish
