#include "support/primal_meshes.h"

#include <random>
#include <set>
#include <utility>

#include "conformance/catalogue.h"
#include "planish/mesh/check.h"
#include "support/random_meshes.h"

namespace planish::test {

PolygonMesh as_triangles(const PolygonMesh& mesh) {
  PolygonMesh result;
  result.positions = mesh.positions;
  result.creases = mesh.creases;
  result.corners = mesh.corners;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 2; i < face.size(); ++i) {
      result.add_face(std::vector<std::int32_t>{face[0], face[i - 1], face[i]});
    }
  }
  return result;
}

PolygonMesh with_random_sharpness(PolygonMesh mesh, double probability, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> chance(0, 1);
  std::set<std::pair<std::int32_t, std::int32_t>> seen;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const auto edge = std::minmax(face[i], face[(i + 1) % face.size()]);
      if (!seen.insert(edge).second || chance(random) > probability) continue;
      mesh.creases.push_back({edge.first, edge.second, static_cast<float>(4 * chance(random))});
    }
  }
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (chance(random) > probability / 10) continue;
    mesh.corners.push_back({v, static_cast<float>(4 * chance(random))});
  }
  return mesh;
}

std::vector<NamedMesh> primal_meshes(PrimalScheme scheme) {
  std::vector<NamedMesh> meshes = closed_meshes();
  for (NamedMesh& mesh : open_meshes()) meshes.push_back(std::move(mesh));
  for (NamedMesh& mesh : sharp_meshes()) meshes.push_back(std::move(mesh));
  meshes.push_back({"semi-sharp closed", with_random_sharpness(random_closed_mesh(7), 0.3, 1)});
  meshes.push_back({"semi-sharp open", with_random_sharpness(random_open_mesh(8), 0.3, 2)});
  PolygonMesh tip = icosphere(1);
  tip.corners.push_back({0, kInfiniteSharpness});
  meshes.push_back({"tip", tip});
  if (scheme == PrimalScheme::Loop) {
    for (NamedMesh& mesh : meshes) mesh.mesh = as_triangles(mesh.mesh);
    // Fans in two faces at a vertex of valence 2 may share an edge.
    std::erase_if(meshes, [](const NamedMesh& mesh) { return !check(mesh.mesh).empty(); });
  }
  return meshes;
}

}  // namespace planish::test
