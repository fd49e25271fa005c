#include "support/mesh_catalogue.h"

#include <random>
#include <set>
#include <string>
#include <utility>

#include "planish/mesh/check.h"
#include "support/random_meshes.h"

namespace planish::test {

std::vector<NamedMesh> closed_meshes() {
  std::vector<NamedMesh> meshes{
      {"tetrahedron", tetrahedron()},
      {"cube", jittered(cube(), 0.2, 1)},
      {"dodecahedron", dodecahedron()},
      {"prism 3", prism(3)},
      {"prism 7", jittered(prism(7), 0.1, 2)},
      {"prism 64", prism(64)},
      {"bipyramid 5", jittered(bipyramid(5), 0.1, 3)},
      {"bipyramid 64", bipyramid(64)},
      {"bipyramid 360", bipyramid(360)},
      {"torus", jittered(torus(9, 7, 1, 0.4), 0.05, 4)},
      {"icosphere 1", icosphere(1)},
      {"cube with split edges", jittered(cube_with_split_edges(), 0.1, 5)},
  };
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    meshes.push_back({"random closed " + std::to_string(seed), random_closed_mesh(seed)});
  }
  return meshes;
}

std::vector<NamedMesh> open_meshes() {
  std::vector<NamedMesh> meshes{
      {"grid 5x4", jittered(flat_grid(5, 4), 0.3, 1)},
      {"grid 1x1", jittered(flat_grid(1, 1), 0.3, 2)},
      {"plate with hole", jittered(plate_with_hole(6), 0.2, 3)},
      {"L", jittered(l_shaped_plate(2), 0.2, 4)},
      {"triangle", single_polygon(3)},
      {"polygon 9", jittered(single_polygon(9), 0.1, 5)},
      {"fan 6", open_fan(6)},
      {"fan 64", open_fan(64)},
  };
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    meshes.push_back({"random open " + std::to_string(seed), random_open_mesh(seed)});
  }
  return meshes;
}

namespace {

PolygonMesh with_tags(PolygonMesh mesh, std::vector<CreaseEdge> creases,
                      std::vector<CornerVertex> corners) {
  mesh.creases = std::move(creases);
  mesh.corners = std::move(corners);
  return mesh;
}

// The re-entrant corner of an L-shaped plate.
PolygonMesh with_reflex_corner() {
  PolygonMesh mesh = l_shaped_plate(2);
  const std::int32_t corner = vertex_at(mesh, {2, 2, 0});
  mesh = jittered(mesh, 0.15, 8);
  mesh.corners.push_back({corner});
  return mesh;
}

// A crease that starts inside the sphere-like mesh and ends inside it.
PolygonMesh with_darts() {
  PolygonMesh mesh = jittered(icosphere(1), 0.05, 6);
  const auto face = mesh.face(7);
  return with_tags(mesh, {{face[0], face[1]}, {face[1], face[2]}}, {});
}

// Creases across a grid: T-junctions on its boundary, a crossing of four in its middle.
PolygonMesh with_crossing_creases() {
  PolygonMesh mesh = jittered(flat_grid(4, 4), 0.15, 7);
  for (int i = 0; i < 4; ++i) {
    mesh.creases.push_back({10 + i, 11 + i});
    mesh.creases.push_back({2 + 5 * i, 7 + 5 * i});
  }
  return mesh;
}

}  // namespace

std::vector<NamedMesh> sharp_meshes() {
  const std::vector<CreaseEdge> top_of_cube{{4, 5}, {5, 7}, {7, 6}, {6, 4}};
  std::vector<NamedMesh> meshes{
      {"cube with creased top", with_tags(jittered(cube(), 0.2, 1), top_of_cube, {})},
      {"cube with creased top and a corner",
       with_tags(jittered(cube(), 0.2, 1), top_of_cube, {{5}})},
      {"one dart", with_tags(jittered(cube(), 0.2, 2), {{0, 1}, {1, 3}}, {})},
      {"darts", with_darts()},
      {"reflex corner", with_reflex_corner()},
      {"crossing creases", with_crossing_creases()},
      {"tagged boundary vertex", with_tags(jittered(flat_grid(3, 3), 0.1, 9), {}, {{2}})},
  };
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    meshes.push_back({"random creases " + std::to_string(seed),
                      with_random_creases(random_open_mesh(seed), 0.2, seed)});
  }
  return meshes;
}

std::vector<NamedMesh> all_meshes() {
  std::vector<NamedMesh> meshes = closed_meshes();
  for (NamedMesh& mesh : open_meshes()) meshes.push_back(std::move(mesh));
  for (NamedMesh& mesh : sharp_meshes()) meshes.push_back(std::move(mesh));
  return meshes;
}

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
  std::vector<NamedMesh> meshes = all_meshes();
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
