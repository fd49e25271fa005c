// A cube in, the surface through its eight corners out, by nothing but the installed package.
#include <planish/planish.h>
#include <planish/reconstruct/reconstruct.h>

#include <array>
#include <cstdio>
#include <glm/geometric.hpp>

namespace {

planish::PolygonMesh cube() {
  planish::PolygonMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  for (const std::array<std::int32_t, 4>& face :
       {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
        std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
    mesh.add_face(face);
  }
  return mesh;
}

// Points with a mesher of one's own: the cube's triangles become its quads again.
bool reconstructs_the_cube() {
  const planish::PolygonMesh mesh = cube();
  const planish::Mesher mesher = [&](std::span<const glm::dvec3>, const planish::Callbacks&) {
    std::vector<planish::Triangle> triangles;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto face = mesh.face(f);
      triangles.push_back({face[0], face[1], face[2]});
      triangles.push_back({face[0], face[2], face[3]});
    }
    return triangles;
  };
  const planish::Reconstruction result =
      planish::reconstruct({.points = mesh.positions}, mesher, {.tolerance = 0});
  return result.mesh.face_count() == 6 && result.statistics.genus == 0;
}

}  // namespace

int main() {
  const planish::PolygonMesh mesh = cube();
  const auto backend = planish::make_cpu_backend();
  const planish::Fit fit = planish::fit(mesh, *backend);
  const planish::SurfaceMesh surface = planish::evaluate(fit.cage, *backend);
  double largest = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    largest = std::max(largest, glm::distance(mesh.positions[i], surface.positions[i]));
  }
  const auto glb = planish::encode_glb(surface, {});
  std::printf("planish %s: %zu positions, %zu bytes, off by %g\n", PLANISH_VERSION,
              surface.positions.size(), glb.size(), largest);
  return reconstructs_the_cube() && largest < 1e-5 && surface.positions.size() > 8 ? 0 : 1;
}
