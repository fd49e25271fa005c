#include "planish/mesh/folded_edges.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_areas.h"

namespace planish {

namespace {

constexpr std::size_t kFoldGrain = 1 << 13;

// The vector areas of all faces, and which pairs of them turn too far.
class FaceAreas {
 public:
  explicit FaceAreas(const PolygonMesh& mesh) : areas_(face_areas(mesh)) {}
  [[nodiscard]] std::size_t count() const { return areas_.size(); }

  [[nodiscard]] bool are_folded(std::int32_t f, std::int32_t g) const {
    static const double least_cosine = std::cos(kFoldedEdgeDegrees * std::numbers::pi / 180);
    const glm::dvec3 &a = areas_[f], &b = areas_[g];
    const double cosine = glm::dot(a, b);
    // Most edges need no length.
    return cosine < 0 && cosine < least_cosine * glm::length(a) * glm::length(b);
  }

  // The rest of the result once is_beside is known.
  void sum_up(FoldedEdges& result) const {
    double whole = 0;
    for (std::size_t f = 0; f < areas_.size(); ++f) {
      const double area = glm::length(areas_[f]);
      whole += area;
      if (!result.is_beside[f]) continue;
      result.area += area;
      if (result.first_face < 0) result.first_face = static_cast<std::int32_t>(f);
    }
    if (whole > 0) result.area /= whole;
  }

 private:
  RawVector<glm::dvec3> areas_;
};

}  // namespace

FoldedEdges folded_edges(const PolygonMesh& mesh) {
  const FaceAreas faces(mesh);
  FoldedEdges result;
  result.is_beside.assign(faces.count(), 0);
  const std::vector<std::uint8_t> all(faces.count(), 1);
  group_edges(mesh, all).for_each([&](std::int32_t, std::span<const FaceSide> sides) {
    if (sides.size() < 2 || !faces.are_folded(sides[0].face, sides[1].face)) return;
    ++result.count;
    result.is_beside[sides[0].face] = result.is_beside[sides[1].face] = 1;
  });
  faces.sum_up(result);
  return result;
}

FoldedEdges folded_edges(const PolygonMesh& mesh, const MeshTopology& topology) {
  const FaceAreas faces(mesh);
  FoldedEdges result;
  result.is_beside.assign(faces.count(), 0);
  // Each face looks at its own edges; each edge counts from one side.
  std::vector<std::int64_t> counts((faces.count() + kFoldGrain - 1) / kFoldGrain, 0);
  parallel_for(counts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin * kFoldGrain; f < std::min(faces.count(), end * kFoldGrain); ++f) {
      const auto face = static_cast<std::int32_t>(f);
      const std::int32_t first = topology.first_corner(face);
      for (std::int32_t c = first; c < first + topology.face_size(face); ++c) {
        const std::int32_t twin = topology.twin(c);
        if (twin < 0 || !faces.are_folded(face, topology.face_of(twin))) continue;
        result.is_beside[f] = 1;
        counts[f / kFoldGrain] += c < twin;
      }
    }
  });
  for (const std::int64_t count : counts) result.count += count;
  faces.sum_up(result);
  return result;
}

}  // namespace planish
