#include "planish/surface/evaluate.h"

#include <gmock/gmock.h>

#include <functional>
#include <glm/geometric.hpp>

#include "planish/core/error.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/level_one_mesh.h"
#include "surface/level_one_states.h"

namespace planish {
namespace {

TEST(LevelOne, OfAnOrdinaryCageGivesTheSameBits) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : test::net_meshes()) {
    for (const BoundaryRule boundary : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
      for (int level = 0; level <= 2; ++level) {
        EvaluateOptions options{.level = level, .weights = Weights::Averaged};
        options.sharp.boundary = boundary;
        const LevelOne level_one = test::first_step(mesh, options.sharp, options.weights);
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
  const SurfaceMesh surface = evaluate(mesh, test::first_step(mesh), *backend, {.level = 2});
  EXPECT_EQ(surface.positions, expected.positions);
  EXPECT_EQ(surface.base_vertices, expected.base_vertices);
  EXPECT_EQ(surface.face_uvs, expected.face_uvs);
  EXPECT_EQ(surface.face_groups, expected.face_groups);
  EXPECT_EQ(surface.colors, expected.colors);
  EXPECT_EQ(surface.face_count(), 47 * 16);
}

TEST(LevelOne, AStateOfAnotherSizeIsRefused) {
  LevelOne level_one = test::first_step(test::cube());
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
  for (const auto& [name, mesh] : test::net_meshes()) {
    const auto limits = limit_positions(mesh, test::first_step(mesh), {});
    const auto expected = limit_positions(mesh, Weights::DooSabin, {});
    for (std::size_t v = 0; v < limits.size(); ++v) {
      EXPECT_LT(glm::length(limits[v] - expected[v]), 1e-14) << name << " vertex " << v;
    }
  }
}

}  // namespace
}  // namespace planish
