#pragma once

#include <array>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/random_kinds.h"

namespace planish::testing {

/// The mesh with its vertices where the surface that it is the cage of has them: what a System has
/// to be given for that surface.
[[nodiscard]] inline PolygonMesh on_surface(PolygonMesh cage) {
  PolygonMesh whole = cage;
  whole.hole_faces.clear();  // their vertices have no rows
  const SurfaceMesh surface = evaluate(whole, *make_cpu_backend(), {.level = 0});
  for (std::size_t row = 0; row < surface.base_vertices.size(); ++row)
    cage.positions[surface.base_vertices[row]] = surface.positions[row];
  return cage;
}

/// Faces in charts, each with an affine map of its own from space to the texture; every other one
/// is turned over.
[[nodiscard]] inline PolygonMesh with_charts(PolygonMesh mesh, std::int32_t charts,
                                             std::uint32_t seed) {
  mesh.positions = through_floats(mesh.positions);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<std::array<double, 8>> maps(static_cast<std::size_t>(charts));
  for (auto& map : maps)
    for (double& entry : map) entry = number(random);
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> known;
  mesh.uvs.clear();
  mesh.face_uvs.clear();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t chart = f * charts / mesh.face_count();
    const auto& m = maps[chart];
    for (const std::int32_t v : mesh.face(f)) {
      const auto [entry, is_new] =
          known.try_emplace({chart, v}, static_cast<std::int32_t>(mesh.uvs.size()));
      const glm::dvec3& p = mesh.positions[v];
      if (is_new)
        mesh.uvs.emplace_back(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                              m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7]);
      mesh.face_uvs.push_back(entry->second);
    }
  }
  return mesh;
}

[[nodiscard]] inline std::vector<PolygonMesh> textured_meshes() {
  return {with_charts(test::torus(9, 7, 2, 0.7), 5, 1),
          with_charts(test::random_closed_mesh(3), 7, 2),
          with_charts(test::with_random_creases(test::random_open_mesh(2), 0.1, 3), 6, 3),
          with_charts(test::cube(), 6, 4), with_charts(test::prism(5), 1, 5),
          // Rings that are evaluated by their sums.
          with_charts(test::prism(40), 1, 6), with_charts(test::bipyramid(36), 3, 7)};
}

}  // namespace planish::testing
