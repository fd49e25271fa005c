#include "planish/mesh/mesh_density.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/mesh/face_areas.h"

namespace planish {

namespace {

// Which faces of a mesh are even, by their vector areas.
class EvenFaces {
 public:
  EvenFaces(const PolygonMesh& mesh, const MeshTopology& topology)
      : topology_(topology), areas_(face_areas(mesh)) {}

  [[nodiscard]] double area(std::int32_t face) const { return glm::length(areas_[face]); }
  [[nodiscard]] bool is_even(std::int32_t face) const {
    const std::int32_t first = topology_.first_corner(face);
    for (std::int32_t c = first; c < first + topology_.face_size(face); ++c) {
      const std::int32_t twin = topology_.twin(c);
      if (twin >= 0 && turns(face, topology_.face_of(twin))) return false;
    }
    return true;
  }

 private:
  // Of a face without area nothing can be told.
  [[nodiscard]] bool turns(std::int32_t f, std::int32_t g) const {
    static const double least_cosine = std::cos(kEvenDegrees * std::numbers::pi / 180);
    return glm::dot(areas_[f], areas_[g]) < least_cosine * area(f) * area(g);
  }

  const MeshTopology& topology_;
  std::vector<glm::dvec3> areas_;
};

struct Areas {
  double all = 0, even = 0;
};

}  // namespace

MeshDensity mesh_density(const PolygonMesh& mesh, const MeshTopology& topology) {
  MeshDensity density;
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v)
    density.vertex_count += topology.corners_at(v).empty() ? 0 : 1;
  if (density.vertex_count < kDenseVertices) return density;
  const EvenFaces faces(mesh, topology);
  const auto areas_of = [&](std::size_t begin, std::size_t end) {
    Areas areas;
    for (auto f = static_cast<std::int32_t>(begin); f < static_cast<std::int32_t>(end); ++f) {
      areas.all += faces.area(f);
      if (faces.is_even(f)) areas.even += faces.area(f);
    }
    return areas;
  };
  constexpr std::size_t kPiece = 1 << 13;
  const Areas areas = ordered_reduce(static_cast<std::size_t>(topology.face_count()), kPiece,
                                     Areas{}, areas_of, [](Areas& total, const Areas& one) {
                                       total.all += one.all;
                                       total.even += one.even;
                                     });
  if (areas.all > 0) density.even_share = areas.even / areas.all;
  return density;
}

}  // namespace planish
