// The library's limit points, normals and control points of every level against the oracles.

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "conformance/catalogue.h"
#include "conformance/level_match.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/b_spline_oracle.h"
#include "support/doo_sabin_tables.h"
#include "support/explicit_doo_sabin.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

constexpr double kRounding = 1e-12;
// Normals are stored in float.
constexpr double kFloatNormal = 5e-7;

std::vector<dvec3> applied(const StencilTable& table, const std::vector<dvec3>& source) {
  const StencilView<double> view = table.view();
  std::vector<dvec3> result(view.row_count(), dvec3(0.0));
  for (int32_t row = 0; row < view.row_count(); ++row) {
    for (int32_t k = 0; k < view.sizes[row]; ++k) {
      const int32_t at = view.offsets[row] + k;
      result[row] += view.weights[at] * source[view.indices[at]];
    }
  }
  return result;
}

struct Rules {
  Weights weights;
  BoundaryRule boundary;
};

// Limit points and normals by evaluate(), control points by the chain of stencil tables.
void expect_levels_agree(const PolygonMesh& mesh, Rules rules, int levels) {
  const auto backend = make_cpu_backend();
  QuadSplitOracle oracle(mesh, rules.weights, rules.boundary);
  LevelMatch match;
  QuadSplit split(mesh);
  split.refine(levels);
  const SharpFeatures features =
      find_sharp_features(mesh, split.topology(), mesh.positions, {.boundary = rules.boundary});
  const SubdivisionChain subdivision(split, features, rules.weights);
  std::vector<dvec3> state = mesh.positions;
  for (int level = 1; level <= levels; ++level) {
    SCOPED_TRACE("level " + std::to_string(level));
    state = applied(step_table(subdivision, level), state);
    const SurfaceMesh surface =
        evaluate(mesh, *backend,
                 {.level = level, .weights = rules.weights, .sharp = {.boundary = rules.boundary}});
    match.advance(surface, oracle);
    EXPECT_LT(match.worst_position(), kRounding);
    EXPECT_LT(match.worst_normal(), kFloatNormal);
    double worst = 0;
    for (int32_t q = 0; q < surface.face_count(); ++q) {
      worst = std::max(worst, glm::distance(state[q], oracle.face_point(match.face_of(q))));
    }
    EXPECT_LT(worst, kRounding) << "control points";
    if (level < levels) oracle.refine();
  }
}

TEST(Levels, ClosedMeshesAgreeWithTheOracle) {
  for (const auto& [name, mesh] : closed_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      expect_levels_agree(mesh, {weights, BoundaryRule::Edge}, 3);
    }
  }
}

TEST(Levels, OpenMeshesAgreeWithTheOracle) {
  for (const auto& [name, mesh] : open_meshes()) {
    for (Weights weights : kBothWeights) {
      for (BoundaryRule boundary : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
        SCOPED_TRACE(name);
        expect_levels_agree(mesh, {weights, boundary}, 3);
      }
    }
  }
}

TEST(Levels, SharpMeshesAgreeWithTheOracle) {
  for (const auto& [name, mesh] : sharp_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      expect_levels_agree(mesh, {weights, BoundaryRule::Edge}, 3);
    }
  }
}

TEST(Levels, FirstControlPointsAreThoseOfExplicitSubdivision) {
  for (const auto& [name, mesh] : closed_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      QuadSplit split(mesh);
      split.refine(1);
      const SharpFeatures features =
          find_sharp_features(mesh, split.topology(), mesh.positions, {});
      const SubdivisionChain subdivision(split, features, weights);
      const std::vector<dvec3> points = applied(step_table(subdivision, 1), mesh.positions);
      const ExplicitMesh level = explicit_levels(mesh, weights, 1);
      ASSERT_EQ(points.size(), level.points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_LT(glm::distance(points[i], level.points[i]), kRounding);
      }
    }
  }
}

TEST(Levels, LimitPositionsAreThoseOfExplicitSubdivision) {
  for (const auto& [name, mesh] : closed_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const std::vector<dvec3> expected = explicit_limit_points(explicit_levels(mesh, weights, 3));
      const std::vector<dvec3> limits = limit_positions(mesh, weights, {});
      ASSERT_EQ(limits.size(), expected.size());
      for (std::size_t v = 0; v < limits.size(); ++v) {
        EXPECT_LT(glm::distance(limits[v], expected[v]), kRounding);
      }
    }
  }
}

TEST(Levels, OpenGridsAreTensorProductBSplines) {
  const int columns = 5, rows = 4;
  const PolygonMesh mesh = jittered(flat_grid(columns, rows), 0.3, 1);
  const BSplineOracle spline(mesh, columns, rows);
  const auto backend = make_cpu_backend();
  for (Weights weights : kBothWeights) {
    for (int level = 0; level <= 5; ++level) {
      EvaluateOptions options{.level = level, .weights = weights};
      options.sharp.boundary = BoundaryRule::EdgeAndCorner;
      const SurfaceMesh surface = evaluate(mesh, *backend, options);
      // A grid whose positions are its parameters is reproduced: it tells each vertex's place.
      const SurfaceMesh where = evaluate(flat_grid(columns, rows), *backend, options);
      ASSERT_EQ(surface.positions.size(), where.positions.size());
      double worst = 0, worst_normal = 0;
      for (std::size_t v = 0; v < surface.positions.size(); ++v) {
        const dvec3 uv = where.positions[v];
        worst = std::max(worst, glm::distance(surface.positions[v], spline.point(uv.x, uv.y)));
        worst_normal = std::max(
            worst_normal, glm::distance(dvec3(surface.normals[v]), spline.normal(uv.x, uv.y)));
      }
      EXPECT_LT(worst, kRounding) << "level " << level;
      EXPECT_LT(worst_normal, kFloatNormal) << "level " << level;
    }
  }
}

}  // namespace
}  // namespace planish::test
