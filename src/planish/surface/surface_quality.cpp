#include "planish/surface/surface_quality.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/stop.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/folded_edges.h"
#include "planish/surface/apex_normals.h"
#include "planish/surface/folded_places.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/quality_sum.h"

namespace planish {

namespace {

// `input`, and `ancestor` of each face in it: null and empty where the reference is another shape.
SurfaceQuality measured_quality(const SurfaceMesh& surface, const ReferenceNormal& reference,
                                std::span<const std::uint8_t> is_beside_folds,
                                const PolygonMesh* input, std::span<const std::int32_t> ancestor) {
  std::optional<ApexNormals> apexes;
  if (input != nullptr) apexes.emplace(*input);
  QualitySum sum;
  FoldedPlaces places;
  StopCheck stop;
  std::vector<glm::dvec3> positions, wanted;
  std::vector<glm::vec3> normals;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    stop.step();
    positions.clear();
    normals.clear();
    wanted.clear();
    const bool is_elsewhere = is_beside_folds.empty() || is_beside_folds[f] == 0;
    for (const std::int32_t v : surface.face(f)) {
      const auto corner = static_cast<std::int32_t>(wanted.size());
      positions.push_back(surface.positions[v]);
      normals.push_back(surface.normals[v]);
      wanted.push_back(reference(f, corner));
    }
    const glm::dvec3* apex = apexes ? apexes->apex_of(ancestor[f]) : nullptr;
    if (apex != nullptr) leave_out_apex(*apex, positions, normals);
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (input != nullptr && glm::dot(glm::dvec3(normals[i]), wanted[i]) < 0)
        places.add({ancestor[f], positions[i]}, is_elsewhere);
    sum.add(positions, normals, wanted, is_elsewhere);
  }
  SurfaceQuality quality = sum.result();
  quality.folded_places = places.take();
  return quality;
}

}  // namespace

SurfaceQuality surface_quality(const SurfaceMesh& surface, const ReferenceNormal& reference,
                               std::span<const std::uint8_t> is_beside_folds) {
  return measured_quality(surface, reference, is_beside_folds, nullptr, {});
}

std::vector<std::uint8_t> beside_folds(const SurfaceMesh& surface, const PolygonMesh& input) {
  const FoldedEdges folds = folded_edges(input);
  const std::vector<std::int32_t> ancestor = ancestor_faces(surface, input);
  std::vector<std::uint8_t> result(ancestor.size());
  std::transform(ancestor.begin(), ancestor.end(), result.begin(),
                 [&](std::int32_t face) { return folds.is_beside[face]; });
  return result;
}

SurfaceQuality surface_quality(const SurfaceMesh& surface, const PolygonMesh& input) {
  const std::vector<std::int32_t> ancestor = ancestor_faces(surface, input);
  glm::dvec3 normal(0.0);
  return measured_quality(
      surface,
      [&](std::int64_t face, std::int32_t corner) {
        if (corner == 0) normal = area_vector(input.positions, input.face(ancestor[face]));
        return normal;
      },
      beside_folds(surface, input), &input, ancestor);
}

}  // namespace planish
