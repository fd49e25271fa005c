#pragma once

#include <filesystem>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "planish/files/mesh_file.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/patches/patch_mesh.h"
#include "support/doo_sabin_tables.h"
#include "support/mesh_catalogue.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {

/// The scenes' meshes without unused vertices.
inline std::vector<NamedMesh> scene_meshes() {
  std::vector<NamedMesh> meshes;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES)) {
    if (entry.path().extension() != ".obj") continue;
    const std::string name = entry.path().filename().string();
    meshes.push_back({name, without_unused_vertices(read_mesh(entry.path()).mesh).mesh});
  }
  return meshes;
}

/// A mesh with what tables and patches need of it. Points are in unit coordinates.
struct PatchCase : ChainCase {
  explicit PatchCase(const PolygonMesh& given, Weights rule = Weights::DooSabin,
                     const SharpFeatureOptions& sharp = {}, int level = 0)
      : ChainCase(given, rule, level, sharp),
        weights(rule),
        topology(split.topology()),
        patches(topology, features) {
    const Placement placement = placement_of(mesh);
    for (const glm::dvec3& p : mesh.positions) points.push_back(placement.to_unit(p));
  }

  Weights weights;
  const MeshTopology& topology;
  PatchMesh patches;
  std::vector<glm::dvec3> points;
};

/// The same with the points of the state that patches are of.
struct SteppedCase : PatchCase {
  explicit SteppedCase(const PolygonMesh& given, Weights rule = Weights::DooSabin, int level = 0)
      : PatchCase(given, rule, {}, level), state(first_step(patches, weights, points)) {}

  /// Those of a patch, as seen from its first one.
  [[nodiscard]] std::vector<glm::dvec3> points_of(const PatchMesh& records,
                                                  const PatchPlace& place) const {
    std::vector<std::int32_t> indices(static_cast<std::size_t>(place.patch.column_count()));
    records.gather(place, indices.data(), 1);
    std::vector<glm::dvec3> result;
    for (const std::int32_t i : indices) result.push_back(state[i] - state[indices[0]]);
    return result;
  }

  RawVector<glm::dvec3> state;
};

struct TableSample {
  glm::dvec3 position{0.0}, du{0.0}, dv{0.0};
};

/// The state of level 1, and the limit rows of `level`, by the chain of stencil tables.
inline std::vector<glm::dvec3> table_state(const PatchCase& c) {
  return applied(step_table(c.subdivision, 1), c.points);
}

inline std::vector<TableSample> table_samples(const PatchCase& c, const LimitRows& limits) {
  std::vector<glm::dvec3> state = table_state(c);
  for (int l = 2; l <= limits.state_level(); ++l)
    state = applied(step_table(c.subdivision, l), state);
  const auto table = limit_table(c.subdivision, limits);
  const auto view = table.view();
  std::vector<TableSample> samples(static_cast<std::size_t>(view.row_count()));
  for (std::int32_t i = 0; i < view.row_count(); ++i) {
    for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
      const glm::dvec3& p = state[view.indices[k]];
      samples[i].position += view.weights[k] * p;
      samples[i].du += view.du_weights[k] * p;
      samples[i].dv += view.dv_weights[k] * p;
    }
  }
  return samples;
}

}  // namespace planish::test
