#include "planish/adaptive/decimate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "limit/limit_case.h"
#include "limit/tessellation_error.h"
#include "planish/adaptive/adaptive_blocks.h"
#include "planish/files/mesh_file.h"
#include "support/calls.h"

namespace planish::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

DecimatedSurface decimated(const LimitCase& c, const DecimationTarget& target,
                           const Callbacks& callbacks = {}) {
  return decimate(
      c.limit,
      {.target = target, .diagonal = c.surface->placement().diagonal, .callbacks = callbacks});
}

LimitCase fitted_scene(const std::string& name) {
  return LimitCase(
      interpolating_cage(read_mesh(std::filesystem::path(PLANISH_SCENES) / name).mesh));
}

std::int64_t triangles_of_faces(const PolygonMesh& mesh) {
  return std::ssize(mesh.face_vertices) - 2 * std::int64_t{mesh.face_count()};
}

// Vertices in one place are one: those of sharp edges have copies.
void expect_closed_as(const LimitCase& c, const SurfaceMesh& surface) {
  const Joints joints = joints_of(surface, true), level_one = joints_of(c.tessellated(1), true);
  EXPECT_EQ(joints.bad_edges, 0);
  EXPECT_EQ(joints.bad_triangles, 0);
  EXPECT_EQ(joints.euler(), level_one.euler());
  EXPECT_EQ(joints.boundary_edges > 0, level_one.boundary_edges > 0);
}

TEST(Decimate, ComesToFewerTrianglesThanTheMeshHasAndToMore) {
  for (const auto& [name, mesh] :
       {NamedMesh{"torus", torus(24, 16, 2, 1)},
        {"sheet", jittered(flat_grid(16, 12), 0.2, 5)},
        {"creased torus", with_random_creases(torus(24, 16, 2, 1), 0.02, 4)}}) {
    const LimitCase c(interpolating_cage(mesh));
    const SurfaceQueries queries(c.limit);
    double last = 1;
    for (const double share : {0.25, 1.0, 8.0}) {
      SCOPED_TRACE(name + ", " + std::to_string(share));
      const auto wanted =
          static_cast<std::int64_t>(share * static_cast<double>(triangles_of_faces(mesh)));
      const DecimatedSurface made = decimated(c, {.triangles = wanted});
      const std::int64_t count = made.surface.mesh.face_count();
      EXPECT_LE(count, wanted);
      EXPECT_GT(count, wanted * 9 / 10);
      EXPECT_EQ(made.figures.wanted, wanted);
      EXPECT_GT(made.figures.finer, 3 * count);
      expect_closed_as(c, made.surface.mesh);
      // What it says of itself, against closest points of the surface itself.
      const TessellationError error = tessellation_error(c, queries, made.surface.mesh, 400);
      EXPECT_LE(error.largest(), 1.15 * made.figures.max);
      EXPECT_GE(error.largest(), 0.5 * made.figures.max);
      EXPECT_LT(made.figures.max, 0.7 * last);
      last = made.figures.max;
    }
  }
}

TEST(Decimate, ScenesKeepADistance) {
  for (const char* const name : {"goblet.obj", "rocker_arm.obj", "bearing_block.obj"}) {
    const LimitCase c = fitted_scene(name);
    const SurfaceQueries queries(c.limit);
    std::int64_t last = std::numeric_limits<std::int64_t>::max();
    for (const double distance : {1e-3, 8e-3}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(distance));
      const DecimatedSurface made = decimated(c, {.distance = distance});
      EXPECT_LE(made.figures.max, distance);
      EXPECT_GT(made.figures.max, 0.3 * distance) << "finer than there is need for";
      EXPECT_LE(tessellation_error(c, queries, made.surface.mesh, 1000).largest(), distance);
      EXPECT_LT(made.surface.mesh.face_count(), last / 2);
      last = made.surface.mesh.face_count();
      expect_closed_as(c, made.surface.mesh);
    }
  }
}

TEST(Decimate, TakesAsManyTrianglesAsEqualSidesWould) {
  const LimitCase c(interpolating_cage(torus(24, 16, 2, 0.8)));
  const DecimatedSurface made = decimated(c, {.edge_length = 0.5});
  // 4 pi^2 R r of the torus, over the area of one.
  const double wanted = 4 * std::pow(3.14159265, 2) * 2 * 0.8 / (std::sqrt(3.0) / 4 * 0.25);
  EXPECT_NEAR(static_cast<double>(made.surface.mesh.face_count()), wanted, 0.02 * wanted);
  EXPECT_NEAR(made.figures.mean_edge_length, 0.5, 0.15);
}

TEST(Decimate, KeepsVerticesOfTheSurfaceWithAllThatTheyHave) {
  PolygonMesh mesh = torus(16, 12, 2, 1);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
    mesh.colors.emplace_back(0.5 + mesh.positions[v].x / 8, 0.5, 0.5, 1);
  // A chart of each half, which meet in seams.
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    mesh.face_groups.push_back(f < mesh.face_count() / 2 ? 0 : 1);
    for (const std::int32_t v : mesh.face(f))
      mesh.face_uvs.push_back(v + mesh.face_groups.back() * mesh.vertex_count());
  }
  for (int half = 0; half < 2; ++half)
    for (const glm::dvec3& at : mesh.positions) mesh.uvs.emplace_back(at.x + 10 * half, at.y);
  mesh.groups = {{.name = "a"}, {.name = "b"}};
  const LimitCase c(mesh);
  const DecimatedSurface made = decimated(c, {.triangles = 300});
  const SurfaceMesh& surface = made.surface.mesh;
  expect_closed_as(c, surface);
  const AdaptiveBlocks blocks(made.surface, c.limit);
  const SurfaceMesh again = blocks.rows_on(c.limit);
  ASSERT_EQ(again.positions.size(), surface.positions.size());
  for (std::size_t i = 0; i < again.positions.size(); ++i) {
    EXPECT_LE(glm::length(again.positions[i] - surface.positions[i]), 1e-12) << i;
    EXPECT_LE(glm::length(again.normals[i] - surface.normals[i]), 1e-6F) << i;
  }
  // The given ones that are left come first, and are what they say.
  EXPECT_GT(surface.base_vertices.size(), 0u);
  const SurfaceMesh level = c.tessellated(0);
  for (std::size_t i = 0; i < surface.base_vertices.size(); ++i)
    EXPECT_LE(glm::length(surface.positions[i] - level.positions[surface.base_vertices[i]]), 1e-12);
  std::vector<glm::dvec2> uvs(surface.uvs.size());
  ASSERT_TRUE(blocks.uvs_of(mesh.uvs, uvs));
  for (std::size_t i = 0; i < uvs.size(); ++i)
    EXPECT_LE(glm::length(uvs[i] - surface.uvs[i]), 1e-9) << i;
  // No triangle reaches over from one chart, and one group, into the other.
  std::set<int> halves;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const int group = surface.face_groups[f];
    for (std::int64_t k = 0; k < 3; ++k)
      EXPECT_EQ(surface.uvs[surface.face_uvs[3 * f + k]].x > 5, group == 1);
    EXPECT_EQ(mesh.face_groups[made.surface.ancestors[f]], group);
    halves.insert(group);
  }
  EXPECT_THAT(halves, ElementsAre(0, 1));
}

TEST(Decimate, IsTheSameForEveryThreadCount) {
  const LimitCase c = fitted_scene("rocker_arm.obj");
  const DecimatedSurface all = decimated(c, {.triangles = 2'000});
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const DecimatedSurface again = decimated(c, {.triangles = 2'000});
  EXPECT_TRUE(again.surface.mesh.positions == all.surface.mesh.positions);
  EXPECT_TRUE(again.surface.mesh.face_vertices == all.surface.mesh.face_vertices);
  EXPECT_EQ(again.figures.max, all.figures.max);
  EXPECT_EQ(again.figures.rms, all.figures.rms);
}

TEST(Decimate, SaysWhereFewerCannotBe) {
  std::vector<Warning> warnings;
  Callbacks callbacks;
  callbacks.warning = [&](const Warning& warning) { warnings.push_back(warning); };
  PolygonMesh mesh = cube();
  for (std::int32_t v = 0; v < 8; ++v) mesh.corners.push_back({v});
  const MeshTopology topology(mesh);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto [a, b] = topology.edge_vertices(e);
    mesh.creases.push_back({a, b});
  }
  const LimitCase c(mesh);
  const DecimatedSurface made = decimated(c, {.triangles = 2}, callbacks);
  EXPECT_EQ(made.surface.mesh.face_count(), 12);
  EXPECT_EQ(made.figures.max, 0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, kTrianglesNotReached);
  EXPECT_THAT(warnings[0].message, HasSubstr("2 triangles are wanted, and 12 are the fewest"));
}

TEST(Decimate, RefusesWhatIsNoTarget) {
  const LimitCase c(cube());
  const auto message = [&](ErrorCode code, const DecimateOptions& options) {
    return message_of(code, [&] { (void)decimate(c.limit, options); });
  };
  constexpr auto kBad = ErrorCode::InvalidArgument;
  EXPECT_THAT(message(kBad, {}), HasSubstr("neither triangles, an edge length nor a distance"));
  EXPECT_THAT(message(kBad, {.target = {.triangles = -1, .distance = 1}}),
              HasSubstr("-1 triangles are none"));
  EXPECT_THAT(message(kBad, {.target = {.edge_length = INFINITY}}), HasSubstr("is none"));
  EXPECT_THAT(message(kBad, {.target = {.triangles = 1}, .diagonal = 0}), HasSubstr("diagonal"));
  EXPECT_THAT(message(ErrorCode::OutOfMemory,
                      {.target = {.triangles = 1'000'000}, .memory_limit_bytes = 1 << 20}),
              HasSubstr(" of memory where "));
}

}  // namespace
}  // namespace planish::test
