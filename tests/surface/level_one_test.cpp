#include "planish/surface/level_one.h"

#include <gmock/gmock.h>

#include <array>
#include <glm/geometric.hpp>
#include <numeric>

#include "planish/backend/cpu_backend.h"
#include "planish/core/error.h"
#include "planish/doosabin/surface_stencils.h"
#include "planish/mesh/check.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/subdivided_mesh.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Level 1 of the surface of an ordinary cage: one Doo-Sabin step.
LevelOne first_step(const PolygonMesh& cage, const SharpFeatureOptions& sharp = {},
                    Weights weights = Weights::DooSabin) {
  const SubdividedMesh base(cage, {.level = 0, .weights = weights, .sharp = sharp});
  LevelOne result;
  result.placement = placement_of(cage);
  std::vector<glm::dvec3> unit;
  for (const glm::dvec3& p : base.used.mesh.positions) unit.push_back(result.placement.to_unit(p));
  const auto size = base.subdivision.state_layout(1).size;
  const auto backend = make_cpu_backend();
  const auto source = backend->upload(unit);
  const auto target = backend->allocate(static_cast<std::int32_t>(size));
  const StencilTable<double> table =
      first_step_table(base.used.mesh, base.subdivision, RowRange{0, size});
  backend->apply(table.view(), *source, *target, 0);
  result.state = backend->download(*target);
  return result;
}

std::vector<test::NamedMesh> closed_meshes() {
  return {{"cube", test::cube()},
          {"prism", test::prism(9)},
          {"bipyramid", test::bipyramid(7)},
          {"torus", test::torus(6, 5, 1.0, 0.4)},
          {"icosphere", test::jittered(test::icosphere(2), 0.05, 3)},
          {"random", test::random_closed_mesh(5)}};
}

std::vector<test::NamedMesh> sharp_meshes() {
  std::vector<test::NamedMesh> meshes = {
      {"grid", test::flat_grid(4, 3)}, {"hole", test::plate_with_hole(5)},
      {"fan", test::open_fan(5)},      {"polygon", test::single_polygon(6)},
      {"L", test::l_shaped_plate(2)},  {"valence two", test::cube_with_split_edges()}};
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    meshes.push_back({"open " + std::to_string(seed), test::random_open_mesh(seed)});
    meshes.push_back({"creased " + std::to_string(seed),
                      test::with_random_creases(test::random_open_mesh(seed), 0.2, seed)});
    meshes.push_back({"closed, creased " + std::to_string(seed),
                      test::with_random_creases(test::random_closed_mesh(seed), 0.1, seed)});
  }
  PolygonMesh cone = test::icosphere(1);
  cone.corners = {{3, kInfiniteSharpness}};
  meshes.push_back({"cone", cone});
  return meshes;
}

std::vector<test::NamedMesh> all_meshes() {
  std::vector<test::NamedMesh> meshes = closed_meshes();
  for (test::NamedMesh& mesh : sharp_meshes()) meshes.push_back(std::move(mesh));
  return meshes;
}

TEST(LevelOne, OfAnOrdinaryCageGivesTheSameBits) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : all_meshes()) {
    for (const BoundaryRule boundary : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
      for (int level = 0; level <= 2; ++level) {
        EvaluateOptions options{.level = level, .weights = Weights::Averaged};
        options.sharp.boundary = boundary;
        const LevelOne level_one = first_step(mesh, options.sharp, options.weights);
        const SurfaceMesh expected = evaluate(mesh, *backend, options);
        const SurfaceMesh surface = evaluate(mesh, level_one, *backend, options);
        EXPECT_EQ(surface.positions, expected.positions) << name << " level " << level;
        EXPECT_EQ(surface.normals, expected.normals) << name << " level " << level;
        EXPECT_EQ(surface.face_vertices, expected.face_vertices);
      }
    }
  }
}

TEST(LevelOne, CarriesWhatRidesOnTheMesh) {
  PolygonMesh mesh = test::torus(8, 6, 1.0, 0.4);
  mesh.positions.insert(mesh.positions.begin(), glm::dvec3(9, 9, 9));  // unused
  for (auto& v : mesh.face_vertices) ++v;
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    mesh.face_uvs.insert(mesh.face_uvs.end(), {0, 1, 2, 3});
    mesh.face_groups.push_back(f % 2);
  }
  mesh.groups = {{"even", "a"}, {"odd", "b"}};
  mesh.colors.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 1));
  mesh.hole_faces = {2};
  const auto backend = make_cpu_backend();
  const SurfaceMesh expected = evaluate(mesh, *backend, {.level = 2});
  const SurfaceMesh surface = evaluate(mesh, first_step(mesh), *backend, {.level = 2});
  EXPECT_EQ(surface.positions, expected.positions);
  EXPECT_EQ(surface.base_vertices, expected.base_vertices);
  EXPECT_EQ(surface.face_uvs, expected.face_uvs);
  EXPECT_EQ(surface.face_groups, expected.face_groups);
  EXPECT_EQ(surface.colors, expected.colors);
  EXPECT_EQ(surface.face_count(), 47 * 16);
}

TEST(LevelOne, AStateOfAnotherSizeIsRefused) {
  LevelOne level_one = first_step(test::cube());
  level_one.state.pop_back();
  for (const auto& use :
       {std::function<void()>(
            [&] { (void)evaluate(test::cube(), level_one, *make_cpu_backend()); }),
        std::function<void()>([&] { (void)level_one_mesh(test::cube(), level_one, {}); })}) {
    try {
      use();
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), testing::HasSubstr("24 control points, and 23"));
    }
  }
}

TEST(LevelOne, LimitPositionsAreThoseOfTheSurface) {
  for (const auto& [name, mesh] : all_meshes()) {
    const auto limits = limit_positions(mesh, first_step(mesh), {});
    const auto expected = limit_positions(mesh, Weights::DooSabin, {});
    for (std::size_t v = 0; v < limits.size(); ++v) {
      EXPECT_LT(glm::length(limits[v] - expected[v]), 1e-14) << name << " vertex " << v;
    }
  }
}

TEST(LevelOneMesh, IsUsable) {
  for (const auto& [name, mesh] : all_meshes()) {
    const PolygonMesh net = level_one_mesh(mesh, first_step(mesh), {});
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
  for (const auto& [name, mesh] : closed_meshes()) {
    // Any interpolating net will do; this one is no Doo-Sabin step of a cage.
    LevelOne level_one = first_step(mesh);
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
  const PolygonMesh net = level_one_mesh(mesh, first_step(mesh), {});
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
  const LevelOne level_one = first_step(mesh);
  const PolygonMesh net = level_one_mesh(mesh, level_one, {});
  ASSERT_EQ(net.colors.size(), net.positions.size());
  // Quads of a grid: colours are linear in the position, as the control points are.
  for (std::size_t i = 0; i < net.positions.size(); ++i) {
    EXPECT_NEAR(net.colors[i].r, net.positions[i].x / 2, 1e-6) << i;
    EXPECT_NEAR(net.colors[i].g, net.positions[i].y, 1e-6) << i;
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

}  // namespace
}  // namespace planish
