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
struct FairCase {
  explicit FairCase(const PolygonMesh& polygons, int levels = 1)
      : mesh(polygons),
        split(mesh),
        features(refine_and_find_features(levels)),
        subdivision(split, features, Weights::DooSabin),
        given(mesh.positions) {
    const Placement placement = placement_of(mesh);
    for (glm::dvec3& p : given) p = placement.to_unit(p);
  }
  [[nodiscard]] FairNet net(std::int32_t polish_steps = 0) const {
    return fair_net(mesh, subdivision, given, {.polish_steps = polish_steps});
  }

  PolygonMesh mesh;
  QuadSplit split;
  SharpFeatures features;
  SubdivisionChain subdivision;
  std::vector<glm::dvec3> given;  ///< unit coordinates

 private:
  SharpFeatures refine_and_find_features(int levels) {
    split.refine(levels);
    return find_sharp_features(mesh, split.topology(), mesh.positions, {});
  }
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
