#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/stencil_table.h"
#include "support/doo_sabin_tables.h"
#include "support/mesh_catalogue.h"
#include "support/random_meshes.h"

namespace planish::test {

/// A mesh with what a fair net is made from.
struct FairCase : ChainCase {
  explicit FairCase(const PolygonMesh& polygons, int levels = 1)
      : ChainCase(polygons, Weights::DooSabin, levels),
        topology(make_fair_topology(mesh, subdivision)),
        given(mesh.positions) {
    const Placement placement = placement_of(mesh);
    for (glm::dvec3& p : given) p = placement.to_unit(p);
    face_normals = unit_face_normals(topology, given);
  }
  [[nodiscard]] FairNet net(std::int32_t polish_steps = 0) const {
    return fair_net(mesh, subdivision, given, {.polish_steps = polish_steps});
  }
  /// With decisions that were made before.
  [[nodiscard]] FairNet net(std::int32_t polish_steps, const FairDecisions& decisions) const {
    return fair_net(mesh, subdivision, given,
                    {.polish_steps = polish_steps, .decisions = &decisions});
  }
  /// A state's points as seen from the given points that they belong to.
  [[nodiscard]] std::vector<glm::dvec3> offsets(std::vector<glm::dvec3> state) const {
    for (std::int32_t i = 0; i < topology.corner_count; ++i)
      state[i] -= given[topology.corner_vertices[i]];
    for (std::size_t s = 0; s < topology.curve_points.size(); ++s)
      state[topology.corner_count + s] -= given[topology.curve_points[s].vertex];
    return state;
  }

  FairTopology topology;
  std::vector<glm::dvec3> given;         ///< unit coordinates
  std::vector<glm::dvec3> face_normals;  ///< of these
};

/// Meshes of every kind, and a larger one of random triangles.
[[nodiscard]] inline std::vector<NamedMesh> fair_meshes() {
  std::vector<NamedMesh> meshes = all_meshes();
  meshes.push_back({"random sphere 600", delaunay_sphere(600, 1)});
  return meshes;
}

/// Limit points of `level` with their normals, from a state of level 1.
struct LimitSamples {
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
};
[[nodiscard]] inline LimitSamples limit_samples(const FairCase& c,
                                                std::span<const glm::dvec3> state, int level) {
  std::vector<glm::dvec3> points(state.begin(), state.end());
  for (int l = 2; l <= level; ++l) {
    std::vector<glm::dvec3> finer(static_cast<std::size_t>(c.subdivision.state_layout(l).size));
    apply(step_table(c.subdivision, l).view(), points, finer);
    points = std::move(finer);
  }
  const LimitRows rows(c.subdivision, level);
  LimitSamples samples;
  samples.positions.resize(static_cast<std::size_t>(rows.count()));
  samples.normals.resize(samples.positions.size());
  apply_limit(limit_table(c.subdivision, rows).view(), points, samples.positions, samples.normals);
  return samples;
}

}  // namespace planish::test
