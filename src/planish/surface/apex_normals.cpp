#include "planish/surface/apex_normals.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace planish {

ApexNormals::ApexNormals(const PolygonMesh& mesh) : mesh_(mesh) {
  if (mesh.corners.empty()) return;
  is_apex_.resize(mesh.positions.size(), 0);
  for (const CornerVertex& corner : mesh.corners)
    is_apex_[corner.vertex] = corner.sharpness >= kInfiniteSharpness ? 1 : 0;
  for (const CreaseEdge& crease : mesh.creases) is_apex_[crease.v0] = is_apex_[crease.v1] = 0;
  // Who is next to a vertex in its faces, less who is before it: nothing where faces go around.
  std::vector<std::uint32_t> around(mesh.positions.size(), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::int32_t from = face[i], to = face[(i + 1) % face.size()];
      around[from] += static_cast<std::uint32_t>(to);
      around[to] -= static_cast<std::uint32_t>(from);
    }
  }
  for (std::size_t v = 0; v < around.size(); ++v)
    if (around[v] != 0) is_apex_[v] = 0;
  if (std::ranges::find(is_apex_, 1) == is_apex_.end()) is_apex_.clear();
}

const glm::dvec3* ApexNormals::apex_of(std::int32_t face) const {
  if (is_apex_.empty()) return nullptr;
  const glm::dvec3* apex = nullptr;
  for (const std::int32_t v : mesh_.face(face))
    if (is_apex_[v] != 0) apex = &mesh_.positions[v];
  return apex;
}

void leave_out_apex(const glm::dvec3& apex, std::span<const glm::dvec3> positions,
                    std::span<glm::vec3> normals) {
  constexpr double kSame = 1e-6;  // squared, of the side behind
  const std::size_t count = positions.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t before = (k + count - 1) % count, behind = (k + 1) % count;
    const glm::dvec3 off = positions[k] - apex, side = positions[behind] - positions[k];
    if (glm::dot(off, off) > kSame * glm::dot(side, side)) continue;
    const glm::vec3 sum = normals[before] + normals[behind];
    if (const float length = glm::length(sum); length > 0) normals[k] = sum / length;
    return;
  }
}

}  // namespace planish
