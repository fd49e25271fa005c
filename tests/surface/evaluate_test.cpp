#include "planish/surface/evaluate.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "planish/core/error.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"

namespace planish {
namespace {

SurfaceMesh evaluated(const PolygonMesh& cage, int level) {
  return evaluate(cage, *make_cpu_backend(), {.level = level});
}

TEST(Evaluate, LevelsStartWithTheSameLimitPointsAndNormals) {
  const PolygonMesh cage = test::prism(5);
  const std::vector<glm::dvec3> limits = limit_positions(cage, Weights::DooSabin, {});
  SurfaceMesh first;
  for (int level = 0; level <= 5; ++level) {
    const SurfaceMesh surface = evaluated(cage, level);
    if (level == 0) first = surface;
    for (std::size_t v = 0; v < limits.size(); ++v) {
      EXPECT_LT(glm::length(surface.positions[v] - limits[v]), 1e-14) << "level " << level;
      EXPECT_LT(glm::length(surface.normals[v] - first.normals[v]), 2e-7f) << "level " << level;
    }
  }
}

TEST(Evaluate, LevelZeroKeepsTheInputsFaces) {
  const PolygonMesh cage = test::prism(5);
  const SurfaceMesh surface = evaluated(cage, 0);
  EXPECT_EQ(surface.face_vertices, cage.face_vertices);
  EXPECT_EQ(surface.face_offsets, cage.face_offsets);
}

TEST(Evaluate, NormalsPointOutwards) {
  const SurfaceMesh surface = evaluated(test::icosphere(1), 3);
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_NEAR(glm::length(surface.normals[v]), 1.0f, 1e-6f);
    EXPECT_GT(glm::dot(glm::dvec3(surface.normals[v]), glm::normalize(surface.positions[v])), 0.98);
  }
}

TEST(Evaluate, LeavesUnusedVerticesOut) {
  PolygonMesh cage = test::cube();
  cage.positions.insert(cage.positions.begin(), glm::dvec3(100, 0, 0));
  for (auto& v : cage.face_vertices) ++v;
  const SurfaceMesh surface = evaluated(cage, 1);
  EXPECT_EQ(surface.base_vertices, (std::vector<std::int32_t>{1, 2, 3, 4, 5, 6, 7, 8}));
  const SurfaceMesh plain = evaluated(test::cube(), 1);
  EXPECT_EQ(surface.positions, plain.positions);
  EXPECT_EQ(limit_positions(cage, Weights::DooSabin, {})[0], glm::dvec3(100, 0, 0));
}

TEST(Evaluate, ReplacesNormalsWhereTangentsAreParallel) {
  // All vertices on one line: no normal anywhere.
  PolygonMesh cage = test::cube();
  for (auto& p : cage.positions) p = glm::dvec3(p.x, 2, 3);
  std::vector<Warning> warnings;
  EvaluateOptions options{.level = 1};
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  const SurfaceMesh surface = evaluate(cage, *make_cpu_backend(), options);
  for (const auto& normal : surface.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "degenerate-normals");
  EXPECT_EQ(warnings[0].count, static_cast<std::int64_t>(surface.normals.size()));
}

// Bicubic about its middle: there both tangents run along x (a B-spline's derivative is half the
// difference of its neighbours), while the facets on both sides lean towards -y.
TEST(Evaluate, CatmullClarkTakesFacetsNormalsWhereTangentsAreParallel) {
  const PolygonMesh cage = test::grid(4, 4, [](double x, double y) {
    const double v = y - 2;
    return glm::dvec3(x + 0.5 * v, v * v, v * (v * v - 1) / 6);
  });
  std::vector<Warning> warnings;
  EvaluateOptions options{.level = 0, .scheme = Scheme::CatmullClark};
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  const SurfaceMesh surface = evaluate(cage, *make_cpu_backend(), options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "degenerate-normals");
  constexpr std::size_t kMiddle = 2 + 5 * 2;
  EXPECT_LT(glm::distance(surface.normals[kMiddle], glm::vec3(0, -1, 0)), 1e-6f);
}

TEST(Evaluate, InteriorValenceTwoHasAUnitNormal) {
  const SurfaceMesh surface = evaluated(test::cube_with_split_edges(), 2);
  for (const auto& normal : surface.normals) EXPECT_NEAR(glm::length(normal), 1.0f, 1e-6f);
}

TEST(Evaluate, SplitsNormalsAlongCreasesOnly) {
  PolygonMesh cage = test::cube();
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 3}, {3, 2}, {2, 0}}) {
    cage.creases.push_back({a, b, kInfiniteSharpness});
  }
  const SurfaceMesh surface = evaluated(cage, 1);
  // 8 + 6 + 12 vertices; the closed crease has 4 vertices and 4 midpoints.
  ASSERT_EQ(surface.positions.size(), 26u + 8u);
  const SurfaceMesh smooth =
      evaluate(cage, *make_cpu_backend(), {.level = 1, .sharp = {.use_tags = false}});
  EXPECT_EQ(smooth.positions.size(), 26u);
}

TEST(Evaluate, RefusesLevelsOutOfRange) {
  for (const int level : {-1, 7}) {
    try {
      (void)evaluated(test::cube(), level);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    }
  }
}

TEST(Evaluate, RefusesWhatDoesNotFitIntoMemoryBeforeTakingIt) {
  try {
    (void)evaluate(test::torus(64, 32, 1, 0.4), *make_cpu_backend(),
                   {.level = 6, .memory_limit_bytes = 1u << 28});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
    EXPECT_NE(std::string(error.what()).find("8,388,608 faces"), std::string::npos) << error.what();
  }
}

TEST(Evaluate, RefusesBrokenMeshes) {
  PolygonMesh cage = test::cube();
  cage.face_vertices[3] = 77;
  EXPECT_THROW((void)evaluated(cage, 1), Error);
}

}  // namespace
}  // namespace planish
