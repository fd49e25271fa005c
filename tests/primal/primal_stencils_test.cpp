// The tables against explicit subdivision that knows no masks.
#include "planish/primal/primal_stencils.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "support/explicit_primal.h"
#include "support/primal_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

// Sdc keeps sharpness and its blends in single precision.
double rounding(const PolygonMesh& mesh) {
  const auto semi_sharp = [](const auto& tag) { return tag.sharpness < kInfiniteSharpness; };
  const bool blends = std::ranges::any_of(mesh.creases, semi_sharp) ||
                      std::ranges::any_of(mesh.corners, semi_sharp);
  return blends ? 1e-6 : 1e-11;
}

std::vector<dvec3> applied(const StencilView<double>& view, const std::vector<dvec3>& source,
                           std::span<const double> weights) {
  std::vector<dvec3> result(view.sizes.size(), dvec3(0.0));
  for (int32_t i = 0; i < view.row_count(); ++i) {
    for (int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
      result[i] += weights[k] * source[view.indices[k]];
    }
  }
  return result;
}

double largest_difference(const std::vector<dvec3>& a, const std::vector<dvec3>& b,
                          std::size_t count) {
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, glm::length(a[i] - b[i]));
  return largest;
}

// Vertices by level: the library orders those of edges by OpenSubdiv's edges, the oracle by their
// ends.
std::vector<dvec3> in_order_of_edges(const PrimalSplit& split, int level,
                                     const ExplicitPrimal& coarse, const ExplicitPrimal& fine) {
  const auto& topology = split.level(level);
  std::map<ExplicitPrimal::Edge, int32_t> middles;
  for (const auto& face : coarse.faces) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      const int32_t a = face[i], b = face[(i + 1) % face.size()];
      middles[{std::min(a, b), std::max(a, b)}] = 0;
    }
  }
  std::vector<dvec3> points = fine.points;
  const auto first = static_cast<int32_t>(fine.points.size() - middles.size());
  int32_t next = first;
  for (auto& [edge, middle] : middles) middle = next++;
  for (int e = 0; e < topology.GetNumEdges(); ++e) {
    const auto ends = topology.GetEdgeVertices(e);
    points[first + e] =
        fine.points[middles.at({std::min(ends[0], ends[1]), std::max(ends[0], ends[1])})];
  }
  return points;
}

class PrimalStencils : public testing::TestWithParam<PrimalScheme> {};

TEST_P(PrimalStencils, OneStepEqualsExplicitSubdivision) {
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    SCOPED_TRACE(name);
    PrimalSplit split(mesh, {GetParam(), {}});
    split.refine(1);
    const auto table = primal_refinement_table(split, 0, {0, split.level(1).GetNumVertices()});
    const auto coarse = explicit_primal(mesh);
    const auto expected = in_order_of_edges(split, 0, coarse, explicit_step(coarse, GetParam()));
    const auto points = applied(table.view(), mesh.positions, table.view().weights);
    ASSERT_EQ(points.size(), expected.size());
    EXPECT_LT(largest_difference(points, expected, points.size()), rounding(mesh));
  }
}

TEST_P(PrimalStencils, BaseVerticesGoToTheirLimits) {
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    SCOPED_TRACE(name);
    PrimalSplit split(mesh, {GetParam(), {}});
    split.refine(1);
    const auto masks = primal_limit_masks(split);
    const auto limits = applied(masks.view(), mesh.positions, masks.view().weights);
    const auto step = explicit_levels(mesh, GetParam(), 1);
    for (int32_t v = 0; v < mesh.vertex_count(); ++v) {
      ASSERT_LT(glm::length(limits[v] - explicit_limit(step, GetParam(), v).point), rounding(mesh))
          << "vertex " << v;
    }
  }
}

// Away from darts and semi-sharp edges six steps of the whole mesh come as near as they can.
TEST_P(PrimalStencils, SixLevelsOfTheWholeMeshApproachTheLimits) {
  const PolygonMesh mesh = GetParam() == PrimalScheme::Loop ? as_triangles(cube()) : prism(5);
  PrimalSplit split(mesh, {GetParam(), {}});
  split.refine(1);
  const auto masks = primal_limit_masks(split);
  const auto limits = applied(masks.view(), mesh.positions, masks.view().weights);
  const auto five = explicit_levels(mesh, GetParam(), 5);
  const auto six = explicit_step(five, GetParam());
  const auto count = static_cast<std::size_t>(mesh.vertex_count());
  const double before = largest_difference(limits, five.points, count);
  const double after = largest_difference(limits, six.points, count);
  EXPECT_LT(after, 2e-3);
  EXPECT_LT(after, 0.45 * before);
}

// Where the two schemes have a tangent plane: not at corners with more than one face and at tips,
// and beside a crease only where its own direction shrinks more slowly than all but one across
// (up to three quads, five triangles, with which the oracle is too slow).
bool has_tangent_plane(PrimalScheme scheme, const VertexStar& star, int32_t sector_index) {
  const auto sharp =
      std::ranges::count_if(star.edge_sharpness, [](float s) { return s >= kInfiniteSharpness; });
  const bool corner = sharp > 2 || star.sharpness >= kInfiniteSharpness;
  if (sharp < 2) return !corner && (star.edge_count() > 2 || star.is_boundary());
  const int32_t faces = sector(star, sector_index).face_count;
  return corner ? faces == 1 : faces <= (scheme == PrimalScheme::Loop ? 4 : 3);
}

TEST_P(PrimalStencils, LimitsAndNormalsOfALevelEqualThoseOfExplicitSubdivision) {
  constexpr int32_t kMostEdges = 6;  // with more the oracle's faces turn towards the plane slowly
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    SCOPED_TRACE(name);
    PrimalSplit split(mesh, {GetParam(), {}});
    split.refine(1);
    const SectorRows rows = primal_sector_rows(split, 1, mesh.vertex_count());
    const auto table = primal_limit_table(split, 1, rows, {0, rows.count()});
    const auto step = explicit_levels(mesh, GetParam(), 1);
    const auto points = in_order_of_edges(split, 0, explicit_primal(mesh), step);
    const auto view = table.view();
    const auto limit = applied(view, points, view.weights);
    const auto du = applied(view, points, view.du_weights);
    const auto dv = applied(view, points, view.dv_weights);
    for (int32_t v = 0; v < mesh.vertex_count(); ++v) {
      VertexStar star;
      gather_star(split, 1, v, star);
      const ExplicitLimit expected = explicit_limit(step, GetParam(), v);
      const auto faces = split.level(1).GetVertexFaces(v);
      for (int i = 0; i < faces.size(); ++i) {
        const int32_t index = sector_of(star, i);
        const int32_t row = rows.row(v, index);
        ASSERT_LT(glm::length(limit[row] - expected.point), rounding(mesh)) << "vertex " << v;
        if (!has_tangent_plane(GetParam(), star, index) || star.edge_count() > kMostEdges) continue;
        const dvec3 normal = glm::cross(du[row], dv[row]);
        if (glm::length(normal) < 1e-9 * glm::length(du[row]) * glm::length(dv[row])) continue;
        const double cosine = glm::dot(glm::normalize(normal), expected.normals.at(faces[i]));
        ASSERT_GT(cosine, 1 - 1e-6) << "vertex " << v << ", face " << faces[i] << " of "
                                    << faces.size() << " edges " << star.edge_count();
      }
    }
  }
}

TEST_P(PrimalStencils, RowsSumToOneAndDerivativesToZero) {
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    SCOPED_TRACE(name);
    PrimalSplit split(mesh, {GetParam(), {}});
    split.refine(2);
    const auto expect_sum = [](const StencilView<double>& view, std::span<const double> weights,
                               double sum) {
      for (int32_t i = 0; i < view.row_count(); ++i) {
        double total = 0;
        for (int32_t k = 0; k < view.sizes[i]; ++k) total += weights[view.offsets[i] + k];
        ASSERT_NEAR(total, sum, 1e-12) << "row " << i;
      }
    };
    const auto masks = primal_limit_masks(split);
    expect_sum(masks.view(), masks.view().weights, 1);
    const auto step = primal_refinement_table(split, 1, {0, split.level(2).GetNumVertices()});
    expect_sum(step.view(), step.view().weights, 1);
    const SectorRows rows = primal_sector_rows(split, 2, split.level(2).GetNumVertices());
    const auto limit = primal_limit_table(split, 2, rows, {0, rows.count()});
    expect_sum(limit.view(), limit.view().weights, 1);
    expect_sum(limit.view(), limit.view().du_weights, 0);
    expect_sum(limit.view(), limit.view().dv_weights, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, PrimalStencils, testing::ValuesIn(kBothPrimalSchemes),
                         [](const auto& test) {
                           return test.param == PrimalScheme::Loop ? "Loop" : "CatmullClark";
                         });

}  // namespace
}  // namespace planish::test
