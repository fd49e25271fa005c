#pragma once

#include <cstdlib>
#include <memory>
#include <random>

#include "planish/pipeline/fit.h"
#include "planish/queries/limit_surface.h"
#include "planish/solve/backend.h"
#include "planish/surface/surface_blocks.h"
#include "support/mesh_catalogue.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {

/// How many times a test asks: `usual` in ctest, or what PLANISH_LONG_RUN says.
inline int run_length(int usual) {
  const char* const given = std::getenv("PLANISH_LONG_RUN");
  return given != nullptr ? std::atoi(given) : usual;
}

/// The limit surface of a cage.
struct LimitCase {
  explicit LimitCase(const PolygonMesh& cage, Weights weights = Weights::DooSabin)
      : mesh(cage),
        surface(std::make_shared<const DooSabinSurface>(mesh, EvaluateOptions{.weights = weights})),
        limit(surface) {}

  [[nodiscard]] SurfaceMesh tessellated(int level) const {
    return collect(*surface->level(level), {});
  }
  /// A place anywhere on the surface, each corner as likely.
  template <class Random>
  [[nodiscard]] SurfaceParameter any_place(Random& random) const {
    const MeshTopology& topology = limit.topology();
    std::uniform_int_distribution<std::int32_t> corner(0, topology.corner_count() - 1);
    std::uniform_real_distribution<double> within(0, 1);
    const std::int32_t c = corner(random);
    const double u = within(random);
    return surface_parameter(topology, c, u, within(random));
  }

  PolygonMesh mesh;
  std::shared_ptr<const DooSabinSurface> surface;
  LimitSurface limit;
};

/// The surface through a mesh's vertices, by its cage.
[[nodiscard]] inline PolygonMesh interpolating_cage(const PolygonMesh& mesh) {
  return fit(mesh, *make_cpu_backend()).cage;
}

/// Closed, open, creased and random meshes.
inline std::vector<NamedMesh> limit_meshes() {
  std::vector<NamedMesh> meshes = all_meshes();
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const std::string name = std::to_string(seed);
    meshes.push_back(
        {"closed " + name, with_random_creases(random_closed_mesh(seed), 0.1 * seed, seed)});
    meshes.push_back({"open " + name, with_random_creases(random_open_mesh(seed), 0.15, seed)});
  }
  return meshes;
}

}  // namespace planish::test
