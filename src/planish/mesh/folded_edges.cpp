#include "planish/mesh/folded_edges.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/mesh/area_vector.h"
#include "planish/mesh/edge_groups.h"

namespace planish {

FoldedEdges folded_edges(const PolygonMesh& mesh) {
  const double least_cosine = std::cos(kFoldedEdgeDegrees * std::numbers::pi / 180);
  const auto face_count = static_cast<std::size_t>(mesh.face_count());
  std::vector<glm::dvec3> areas(face_count);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    areas[f] = area_vector(mesh.positions, mesh.face(f));
  }
  FoldedEdges result;
  result.is_beside.assign(face_count, 0);
  const std::vector<std::uint8_t> all(face_count, 1);
  group_edges(mesh, all).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    if (sides.size() < 2) return;
    const glm::dvec3 &a = areas[sides[0].face], &b = areas[sides[1].face];
    if (!(glm::dot(a, b) < least_cosine * glm::length(a) * glm::length(b))) return;
    ++result.count;
    result.is_beside[sides[0].face] = result.is_beside[sides[1].face] = 1;
  });
  double whole = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    whole += glm::length(areas[f]);
    if (!result.is_beside[f]) continue;
    result.area += glm::length(areas[f]);
    if (result.first_face < 0) result.first_face = f;
  }
  if (whole > 0) result.area /= whole;
  return result;
}

}  // namespace planish
