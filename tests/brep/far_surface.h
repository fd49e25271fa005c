#pragma once

#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/ptexIndices.h>

#include <array>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/solve/refiner.h"

namespace planish::test {

/// A Catmull-Clark surface by OpenSubdiv's own adaptive patches.
class FarSurface {
 public:
  explicit FarSurface(const PolygonMesh& mesh)
      : topology_(mesh),
        refiner_(make_refiner(mesh, {OpenSubdiv::Sdc::SCHEME_CATMARK, {}}, topology_)),
        faces_(*refiner_) {
    namespace Far = OpenSubdiv::Far;
    constexpr int kLevels = 8;
    Far::TopologyRefiner::AdaptiveOptions adaptive(kLevels);
    adaptive.useInfSharpPatch = true;
    refiner_->RefineAdaptive(adaptive);
    Far::PatchTableFactory::Options options(kLevels);
    options.useInfSharpPatch = true;
    options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_BILINEAR_BASIS);
    table_.reset(Far::PatchTableFactory::Create(*refiner_, options));
    map_.emplace(*table_);
    points_.resize(static_cast<std::size_t>(refiner_->GetNumVerticesTotal()));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) points_[i].value = mesh.positions[i];
    const Far::PrimvarRefinerReal<double> refined(*refiner_);
    Point* from = points_.data();
    for (int level = 1; level <= refiner_->GetMaxLevel(); ++level) {
      Point* const to = from + refiner_->GetLevel(level - 1).GetNumVertices();
      refined.Interpolate(level, from, to);
      from = to;
    }
  }

  struct Place {
    glm::dvec3 position{}, normal{};  ///< the normal of unit length
  };
  /// Of a corner's quarter of its quad, u along its leading edge; nothing where no regular patch is
  /// so small.
  [[nodiscard]] std::optional<Place> at(std::int32_t corner, double u, double v) const {
    const std::int32_t face = topology_.face_of(corner), place = topology_.place_of(corner);
    const bool is_quad = topology_.face_size(face) == 4;
    double s = u, t = v;
    if (is_quad) {
      s = place == 0 ? u / 2 : place == 1 ? 1 - v / 2 : place == 2 ? 1 - u / 2 : v / 2;
      t = place == 0 ? v / 2 : place == 1 ? u / 2 : place == 2 ? 1 - v / 2 : 1 - u / 2;
    }
    const auto* const patch = map_->FindPatch(faces_.GetFaceId(face) + (is_quad ? 0 : place), s, t);
    if (patch == nullptr ||
        table_->GetPatchDescriptor(*patch).GetType() != OpenSubdiv::Far::PatchDescriptor::REGULAR)
      return {};
    std::array<double, 16> weights{}, by_s{}, by_t{};
    table_->EvaluateBasis(*patch, s, t, weights.data(), by_s.data(), by_t.data());
    const auto vertices = table_->GetPatchVertices(*patch);
    glm::dvec3 sum(0.0), ds(0.0), dt(0.0);
    for (std::size_t k = 0; k < 16; ++k) {
      const glm::dvec3& p = points_[vertices[static_cast<int>(k)]].value;
      sum += weights[k] * p;
      ds += by_s[k] * p;
      dt += by_t[k] * p;
    }
    return Place{sum, glm::normalize(glm::cross(ds, dt))};
  }

 private:
  // A primvar of OpenSubdiv's protocol.
  struct Point {
    glm::dvec3 value{0.0};
    void Clear() { value = glm::dvec3(0.0); }
    void AddWithWeight(const Point& other, double weight) { value += weight * other.value; }
  };

  MeshTopology topology_;
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
  OpenSubdiv::Far::PtexIndices faces_;
  std::unique_ptr<const OpenSubdiv::Far::PatchTable> table_;
  std::optional<OpenSubdiv::Far::PatchMap> map_;
  std::vector<Point> points_;
};

}  // namespace planish::test
