#include "planish/surface/level_one_mesh.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>
#include <random>
#include <set>

#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "surface/level_one_states.h"

namespace planish {
namespace {

TEST(LevelOneMesh, IsUsable) {
  for (const auto& [name, mesh] : test::net_meshes()) {
    const PolygonMesh net = level_one_mesh(mesh, test::first_step(mesh), {});
    const auto problems = check(net);
    EXPECT_TRUE(problems.empty()) << name << ": " << problems.front().message;
    std::vector<bool> used(net.positions.size());
    for (const std::int32_t v : net.face_vertices) used[v] = true;
    EXPECT_EQ(std::accumulate(used.begin(), used.end(), 0u), net.positions.size()) << name;
  }
}

// On closed smooth meshes it is a cage: of the same surface, whose vertices (the limit points at
// the middles of its faces) are those of the first quad split.
TEST(LevelOneMesh, OfAClosedSmoothMeshIsADooSabinCage) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : test::smooth_net_meshes()) {
    // Any interpolating net will do; this one is no Doo-Sabin step of a cage.
    LevelOne level_one = test::first_step(mesh);
    for (std::size_t i = 0; i < level_one.state.size(); ++i) {
      level_one.state[i] *= 1.0 + 0.05 * static_cast<double>(i % 7);
    }
    const PolygonMesh cage = level_one_mesh(mesh, level_one, {});
    const SurfaceMesh expected = evaluate(mesh, level_one, *backend, {.level = 1});
    const SurfaceMesh surface = evaluate(cage, *backend, {.level = 1});
    const auto first = static_cast<std::size_t>(cage.vertex_count());
    ASSERT_EQ(static_cast<std::size_t>(cage.face_count()), expected.positions.size());
    for (std::size_t i = 0; i < expected.positions.size(); ++i) {
      EXPECT_LT(glm::length(surface.positions[first + i] - expected.positions[i]), 1e-13)
          << name << " face " << i;
      EXPECT_LT(glm::length(surface.normals[first + i] - expected.normals[i]), 1e-6f)
          << name << " face " << i;
    }
  }
}

TEST(LevelOneMesh, ASharpEdgeHasAQuadOnEachSide) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  const PolygonMesh net = level_one_mesh(mesh, test::first_step(mesh), {});
  // 4 smooth vertices and 4 with two sectors, 6 faces, 8 smooth edges and 4 with two quads.
  EXPECT_EQ(net.face_count(), 4 + 8 + 6 + 8 + 8);
  EXPECT_EQ(net.vertex_count(), 24 + 8);
  // Every segment of the closed curve is tagged: 4 edges' and 4 vertices'.
  EXPECT_EQ(net.creases.size(), 8u);
  for (const CreaseEdge& crease : net.creases) {
    EXPECT_GE(std::min(crease.v0, crease.v1), 24);
  }
}

TEST(LevelOneMesh, CarriesColoursAndGroups) {
  PolygonMesh mesh = test::flat_grid(2, 1);
  mesh.groups = {{"left", "red"}, {"right", "blue"}};
  mesh.face_groups = {0, 1};
  for (const glm::dvec3& p : mesh.positions) mesh.colors.emplace_back(p.x / 2, p.y, 0, 1);
  mesh.attributes = {{"x", {}, 1}};
  for (const glm::dvec3& p : mesh.positions)
    mesh.attributes[0].values.push_back(static_cast<float>(p.x));
  const LevelOne level_one = test::first_step(mesh);
  const PolygonMesh net = level_one_mesh(mesh, level_one, {});
  ASSERT_EQ(net.colors.size(), net.positions.size());
  ASSERT_EQ(net.attributes[0].count(), net.positions.size());
  // Quads of a grid: colours are linear in the position, as the control points are.
  for (std::size_t i = 0; i < net.positions.size(); ++i) {
    EXPECT_NEAR(net.colors[i].r, net.positions[i].x / 2, 1e-6) << i;
    EXPECT_NEAR(net.colors[i].g, net.positions[i].y, 1e-6) << i;
    EXPECT_NEAR(net.attributes[0].values[i], net.positions[i].x, 1e-6) << i;
  }
  ASSERT_EQ(net.face_groups.size(), static_cast<std::size_t>(net.face_count()));
  for (std::int32_t f = 0; f < net.face_count(); ++f) {
    double least = 2, greatest = 0;
    for (const std::int32_t v : net.face(f)) {
      least = std::min(least, net.positions[v].x);
      greatest = std::max(greatest, net.positions[v].x);
    }
    if (greatest < 1) {
      EXPECT_EQ(net.face_groups[f], 0);
    }
    if (least > 1) {
      EXPECT_EQ(net.face_groups[f], 1);
    }
  }
}

// Some faces of every mesh.
PolygonMesh with_holes(PolygonMesh mesh, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (random() % 3 == 0) mesh.hole_faces.push_back(f);
  }
  return mesh;
}

double area_of(const PolygonMesh& mesh, bool holes) {
  const std::set<std::int32_t> tagged(mesh.hole_faces.begin(), mesh.hole_faces.end());
  double area = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (tagged.contains(f) == holes) {
      area += glm::length(area_vector(mesh.positions, mesh.face(f)));
    }
  }
  return area;
}

std::set<std::pair<std::int32_t, std::int32_t>> boundary_of(const PolygonMesh& mesh) {
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::pair edge(face[i], face[(i + 1) % face.size()]);
      if (edges.erase({edge.second, edge.first}) == 0) edges.insert(edge);
    }
  }
  return edges;
}

double crease_length(const PolygonMesh& mesh) {
  double length = 0;
  for (const CreaseEdge& crease : mesh.creases)
    length += glm::distance(mesh.positions[crease.v0], mesh.positions[crease.v1]);
  return length;
}

TEST(LevelOneMesh, HolesCutPolygonsAndLeaveNoGap) {
  for (const auto& [name, whole] : test::net_meshes()) {
    for (std::uint32_t seed = 1; seed <= 3; ++seed) {
      const PolygonMesh mesh = with_holes(whole, seed);
      const LevelOne level_one = test::first_step(mesh);
      const PolygonMesh net = level_one_mesh(mesh, level_one, {});
      const auto problems = check(net);
      EXPECT_TRUE(problems.empty()) << name << ": " << problems.front().message;
      std::vector<bool> used(net.positions.size());
      for (const std::int32_t v : net.face_vertices) used[v] = true;
      EXPECT_EQ(std::accumulate(used.begin(), used.end(), 0u), net.positions.size()) << name;
      // The net's borders are those that it has without holes, whose segments a cut may halve:
      // none at all where the mesh is closed.
      const PolygonMesh without = level_one_mesh(whole, level_one, {});
      EXPECT_NEAR(crease_length(net), crease_length(without), 1e-12) << name;
      const auto plain = boundary_of(without);
      const auto cut = boundary_of(net);
      if (plain.empty()) {
        EXPECT_TRUE(cut.empty()) << name;
      }
      EXPECT_LE(cut.size(), 2 * plain.size()) << name;
      EXPECT_EQ(net.hole_faces.empty(), mesh.hole_faces.empty()) << name;
    }
  }
}

// The net of a flat grid is flat and reaches as far, so that tagged parts have the holes' area.
TEST(LevelOneMesh, HolesKeepTheirArea) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const PolygonMesh mesh = with_holes(test::flat_grid(7, 5), seed);
    const SharpFeatureOptions sharp{.boundary = BoundaryRule::EdgeAndCorner};
    const PolygonMesh net = level_one_mesh(mesh, test::first_step(mesh, sharp), sharp);
    EXPECT_NEAR(area_of(net, true), static_cast<double>(mesh.hole_faces.size()), 1e-12);
    EXPECT_NEAR(area_of(net, false), 35.0 - static_cast<double>(mesh.hole_faces.size()), 1e-12);
  }
}

TEST(LevelOneMesh, TheCageGivesTheStateBack) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, whole] : test::net_meshes()) {
    PolygonMesh mesh = with_holes(whole, 4);
    mesh.positions.insert(mesh.positions.begin(), glm::dvec3(9, 9, 9));  // unused
    for (auto& v : mesh.face_vertices) ++v;
    for (CreaseEdge& crease : mesh.creases) ++crease.v0, ++crease.v1;
    for (CornerVertex& corner : mesh.corners) ++corner.vertex;
    const LevelOne level_one = test::first_step(mesh);
    const LevelOne again = level_one_of_cage(mesh, level_one_mesh(mesh, level_one, {}), {});
    const SurfaceMesh expected = evaluate(mesh, level_one, *backend, {.level = 1});
    const SurfaceMesh surface = evaluate(mesh, again, *backend, {.level = 1});
    EXPECT_EQ(surface.face_vertices, expected.face_vertices) << name;
    ASSERT_EQ(surface.positions.size(), expected.positions.size()) << name;
    for (std::size_t i = 0; i < surface.positions.size(); ++i) {
      EXPECT_LT(glm::length(surface.positions[i] - expected.positions[i]), 1e-13) << name;
    }
  }
}

TEST(LevelOneMesh, AForeignCageIsRefused) {
  const auto message = [](const PolygonMesh& mesh, const PolygonMesh& cage) -> std::string {
    try {
      (void)level_one_of_cage(mesh, cage, {});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      return error.what();
    }
    return "none";
  };
  const PolygonMesh cube = test::cube();
  PolygonMesh cage = level_one_mesh(cube, test::first_step(cube), {});
  EXPECT_EQ(message(cube, cage), "none");
  std::swap(cage.face_vertices[0], cage.face_vertices[1]);
  EXPECT_THAT(message(cube, cage), testing::HasSubstr("face 0 has other corners"));
  EXPECT_THAT(message(test::prism(5), cage),
              testing::HasSubstr("30 control points, and 24 are given"));
  EXPECT_THAT(message(test::tetrahedron(), cage), testing::HasSubstr("26 faces for 14"));
}

}  // namespace
}  // namespace planish
