#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "planish/doosabin/limit_masks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// A mesh with what stands between it and the solve.
struct PreparedMesh {
  explicit PreparedMesh(PolygonMesh input, Weights weights = Weights::DooSabin)
      : mesh(std::move(input)),
        topology(mesh),
        features(find_sharp_features(mesh, topology, mesh.positions, {})),
        masks(limit_masks(Subdivision(topology, features, weights))),
        bound(spectral_bound(mesh, weights)),
        valence(valences(topology)) {
    const Placement placement = placement_of(mesh);
    for (const glm::dvec3& position : mesh.positions) given.push_back(placement.to_unit(position));
  }

  [[nodiscard]] std::vector<glm::dvec3> limits_of(const std::vector<glm::dvec3>& points) const {
    const StencilView<double> view = masks.view();
    std::vector<glm::dvec3> limits(points.size(), glm::dvec3(0.0));
    for (std::int32_t i = 0; i < view.row_count(); ++i) {
      for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
        limits[i] += view.weights[k] * points[view.indices[k]];
      }
    }
    return limits;
  }

  PolygonMesh mesh;
  MeshTopology topology;
  SharpFeatures features;
  StencilTable masks;
  double bound;
  std::vector<double> valence;
  std::vector<glm::dvec3> given;  ///< unit coordinates
};

}  // namespace planish::bench
