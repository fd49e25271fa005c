#pragma once

#include <vector>

#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {

/// Level 1 of the surface of an ordinary cage: one Doo-Sabin step.
inline LevelOne first_step(const PolygonMesh& cage, const SharpFeatureOptions& sharp = {},
                           Weights weights = Weights::DooSabin) {
  const DooSabinSurface base(cage, {.weights = weights, .sharp = sharp});
  LevelOne result;
  result.placement = base.placement();
  result.state.assign(base.state().begin(), base.state().end());
  return result;
}

inline std::vector<NamedMesh> smooth_net_meshes() {
  return {{"cube", cube()},
          {"prism", prism(9)},
          {"bipyramid", bipyramid(7)},
          {"torus", torus(6, 5, 1.0, 0.4)},
          {"icosphere", jittered(icosphere(2), 0.05, 3)},
          {"random", random_closed_mesh(5)}};
}

inline std::vector<NamedMesh> sharp_net_meshes() {
  std::vector<NamedMesh> meshes = {
      {"grid", flat_grid(4, 3)}, {"hole", plate_with_hole(5)},
      {"fan", open_fan(5)},      {"polygon", single_polygon(6)},
      {"L", l_shaped_plate(2)},  {"valence two", cube_with_split_edges()}};
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    meshes.push_back({"open " + std::to_string(seed), random_open_mesh(seed)});
    meshes.push_back({"creased " + std::to_string(seed),
                      with_random_creases(random_open_mesh(seed), 0.2, seed)});
    meshes.push_back({"closed, creased " + std::to_string(seed),
                      with_random_creases(random_closed_mesh(seed), 0.1, seed)});
  }
  PolygonMesh cone = icosphere(1);
  cone.corners = {{3, kInfiniteSharpness}};
  meshes.push_back({"cone", cone});
  return meshes;
}

/// Closed, open and creased, with darts and a cone.
inline std::vector<NamedMesh> net_meshes() {
  std::vector<NamedMesh> meshes = smooth_net_meshes();
  for (NamedMesh& mesh : sharp_net_meshes()) meshes.push_back(std::move(mesh));
  return meshes;
}

}  // namespace planish::test
