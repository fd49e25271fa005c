#include "planish/files/shared/split_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <tuple>
#include <type_traits>
#include <utility>

#include "planish/core/raw_vector.h"
#include "planish/files/shared/weld.h"

namespace planish {
namespace {

constexpr std::int32_t kNoNormal = -1;

// An edge as a face has it: its vertices in order, and the normals there.
struct Side {
  std::array<std::int32_t, 2> edge, normals;
};

std::array<std::int32_t, 2> edge_of(std::int32_t a, std::int32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

std::vector<Side> sides_of(const PolygonMesh& mesh, const CornerNormals& normals) {
  std::vector<Side> sides;
  sides.reserve(mesh.face_vertices.size());
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    const std::int32_t begin = mesh.face_offsets[face], size = mesh.face_size(face);
    for (std::int32_t k = 0; k < size; ++k) {
      std::int32_t from = begin + k, to = begin + (k + 1) % size;
      if (mesh.face_vertices[from] > mesh.face_vertices[to]) std::swap(from, to);
      if (mesh.face_vertices[from] == mesh.face_vertices[to]) continue;
      sides.push_back({{mesh.face_vertices[from], mesh.face_vertices[to]},
                       {normals.of_corners[from], normals.of_corners[to]}});
    }
  }
  std::ranges::sort(sides, std::less<>(),
                    [](const Side& side) { return std::tie(side.edge, side.normals); });
  return sides;
}

class NormalsDiffer {
 public:
  explicit NormalsDiffer(const CornerNormals& normals) : values_(normals.values) {}

  bool operator()(std::int32_t a, std::int32_t b) const {
    if (a == b || a == kNoNormal || b == kNoNormal) return false;
    const glm::dvec3 u = values_[a], v = values_[b];
    const double lengths = glm::length(u) * glm::length(v);
    if (!(lengths > 0) || !std::isfinite(lengths)) return false;
    return glm::dot(u, v) < least_cosine_ * lengths;
  }

 private:
  const std::vector<glm::vec3>& values_;
  double least_cosine_ = std::cos(glm::radians(kSplitDegrees));
};

}  // namespace

void mark_split_normals(PolygonMesh& mesh, const CornerNormals& normals) {
  std::vector<std::array<std::int32_t, 2>> tagged;
  for (const CreaseEdge& crease : mesh.creases) tagged.push_back(edge_of(crease.v0, crease.v1));
  std::ranges::sort(tagged);
  const std::vector<Side> sides = sides_of(mesh, normals);
  const NormalsDiffer differ(normals);
  for (auto first = sides.begin(); first != sides.end();) {
    const auto next =
        std::find_if(first, sides.end(), [&](const Side& s) { return s.edge != first->edge; });
    const bool is_split = std::any_of(first, next, [&](const Side& side) {
      return differ(first->normals[0], side.normals[0]) ||
             differ(first->normals[1], side.normals[1]);
    });
    if (is_split && !std::ranges::binary_search(tagged, first->edge))
      mesh.creases.push_back({first->edge[0], first->edge[1]});
    first = next;
  }
}

void weld_repeated_vertices(MeshFile& file) {
  PolygonMesh& mesh = file.mesh;
  const std::size_t count = mesh.positions.size();
  WeldedPositions welded = weld(mesh.positions);
  if (welded.positions.size() == count) return;
  file.welded_vertex_count += static_cast<std::int64_t>(count - welded.positions.size());
  const auto rename = [&](std::int32_t& vertex) { vertex = welded.indices[vertex]; };
  for (std::int32_t& vertex : mesh.face_vertices) rename(vertex);
  for (CreaseEdge& crease : mesh.creases) {
    rename(crease.v0);
    rename(crease.v1);
  }
  std::erase_if(mesh.creases, [](const CreaseEdge& crease) { return crease.v0 == crease.v1; });
  for (CornerVertex& corner : mesh.corners) rename(corner.vertex);
  // The first vertex's stays.
  const auto gather = [&](auto& values) {
    if (values.empty()) return;
    std::remove_reference_t<decltype(values)> kept(welded.positions.size());
    for (std::size_t i = count; i-- > 0;) kept[welded.indices[i]] = values[i];
    values = std::move(kept);
  };
  gather(mesh.colors);
  for (VertexAttribute& attribute : mesh.attributes) gather(attribute.values);
  mesh.positions = std::move(welded.positions);
}

}  // namespace planish
