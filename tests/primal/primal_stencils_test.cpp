#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/error.h"
#include "planish/primal/primal_stencils.h"
#include "support/explicit_primal.h"
#include "support/mesh_catalogue.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

constexpr double kRounding = 1e-14;

VertexStar smooth_star(PrimalScheme scheme, int n) {
  VertexStar star;
  star.face_count = n;
  for (int i = 0; i < n; ++i) {
    star.edge_ends.push_back(2 * i + 1);
    star.edge_sharpness.push_back(0);
    if (scheme == PrimalScheme::CatmullClark) star.face_ends.push_back(2 * i + 2);
  }
  return star;
}

// Halstead, Kass & DeRose 1993: n^2, 4 and 1 over n (n + 5).
TEST(StarLimits, CatmullClarkIsTheClosedForm) {
  StarLimits limits(PrimalScheme::CatmullClark);
  for (int n = 2; n <= 40; ++n) {
    const StarLimit& limit = limits.limit(smooth_star(PrimalScheme::CatmullClark, n), 0);
    const double whole = n * (n + 5.0);
    ASSERT_NEAR(limit.position.vertex, n * n / whole, kRounding) << n;
    for (int i = 0; i < n; ++i) {
      ASSERT_NEAR(limit.position.edges[i], 4 / whole, kRounding) << n;
      ASSERT_NEAR(limit.position.faces[i], 1 / whole, kRounding) << n;
    }
  }
}

// Loop 1987: 1 / (3 / (8 beta) + n) for each neighbour.
TEST(StarLimits, LoopIsTheClosedForm) {
  StarLimits limits(PrimalScheme::Loop);
  for (int n = 3; n <= 40; ++n) {
    const StarLimit& limit = limits.limit(smooth_star(PrimalScheme::Loop, n), 0);
    const double a = 3.0 / 8.0 + std::cos(2 * std::numbers::pi / n) / 4.0;
    const double beta = (5.0 / 8.0 - a * a) / n;
    for (int i = 0; i < n; ++i) {
      ASSERT_NEAR(limit.position.edges[i], 1 / (3 / (8 * beta) + n), kRounding) << n;
    }
  }
}

// A crease whose sharpness has decayed weighs like none; one that decays at once like a mix.
TEST(StarLimits, SemiSharpnessRunsFromSmoothToSharp) {
  VertexStar star = smooth_star(PrimalScheme::CatmullClark, 4);
  StarLimits limits(PrimalScheme::CatmullClark);
  double previous = 1;
  for (const float sharpness : {0.0f, 0.5f, 1.0f, 2.0f, 4.0f, 9.5f, 10.0f}) {
    star.edge_sharpness[0] = star.edge_sharpness[2] = sharpness;
    const double across = limits.limit(star, 0).position.edges[1];
    EXPECT_LT(across, previous) << sharpness;
    previous = across;
  }
  EXPECT_EQ(previous, 0);
}

TEST(StarLimits, SectorsFollowTheSharpEdges) {
  VertexStar star = smooth_star(PrimalScheme::CatmullClark, 6);
  EXPECT_EQ(sector_count(star), 1);
  star.edge_sharpness[1] = kInfiniteSharpness;
  EXPECT_EQ(sector_count(star), 1);
  star.edge_sharpness[4] = kInfiniteSharpness;
  star.edge_sharpness[2] = 9.0f;  // decays
  ASSERT_EQ(sector_count(star), 2);
  EXPECT_EQ(sector(star, 0).first_edge, 1);
  EXPECT_EQ(sector(star, 0).face_count, 3);
  EXPECT_EQ(sector(star, 1).first_edge, 4);
  EXPECT_EQ(sector(star, 1).face_count, 3);
  EXPECT_EQ(sector_of(star, 3), 0);
  EXPECT_EQ(sector_of(star, 0), 1);
}

TEST(PrimalSplit, CountsLevelsWithoutMakingThem) {
  for (const PrimalScheme scheme : {PrimalScheme::CatmullClark, PrimalScheme::Loop}) {
    PrimalSplit split(test::icosphere(1), {scheme, {}});
    const auto counts = split.counts_to(3);
    split.refine(3);
    for (int l = 0; l <= 3; ++l) {
      EXPECT_EQ(counts[l].vertices, split.level(l).GetNumVertices());
      EXPECT_EQ(counts[l].edges, split.level(l).GetNumEdges());
      EXPECT_EQ(counts[l].faces, split.level(l).GetNumFaces());
    }
  }
}

void expect_refused(const PolygonMesh& mesh, PrimalScheme scheme, std::int64_t face,
                    const char* message) {
  try {
    (void)PrimalSplit(mesh, {scheme, {}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
    EXPECT_EQ(error.element(), face);
    EXPECT_STREQ(error.what(), message);
  }
}

TEST(PrimalSplit, LoopNamesTheFirstFaceThatIsNoTriangle) {
  expect_refused(test::make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}},
                                 {{1, 4, 2}, {0, 1, 2, 3}}),
                 PrimalScheme::Loop, 1,
                 "face 1 has 4 corners, and Loop subdivision knows triangles only; split the faces "
                 "into triangles, or take catmull-clark or doo-sabin");
}

// Before memory is taken for it: of 100,000 corners 600 GB.
TEST(PrimalSplit, CatmullClarkNamesAFaceThatIsTooLarge) {
  EXPECT_NO_THROW((void)PrimalSplit(test::prism(2896), {}));  // two of them: 16,773,632
  expect_refused(test::prism(2897), PrimalScheme::CatmullClark, 0,
                 "face 0 has 2897 corners: Catmull-Clark's stencils take the square of a face's "
                 "corners, 16785218 here and 16777216 at most; split its large faces, or take "
                 "doo-sabin");
}

TEST(PrimalSplit, TagsCanBeIgnoredAndBoundariesHaveCorners) {
  PolygonMesh mesh = test::flat_grid(2, 2);
  mesh.creases.push_back({1, 4, 2.5f});
  const PrimalSplit plain(mesh, {PrimalScheme::CatmullClark, {BoundaryRule::Edge, false}});
  const PrimalSplit cornered(mesh,
                             {PrimalScheme::CatmullClark, {BoundaryRule::EdgeAndCorner, true}});
  float plain_sum = 0, sum = 0;
  for (int e = 0; e < plain.level(0).GetNumEdges(); ++e) {
    if (plain.level(0).IsEdgeBoundary(e)) continue;
    plain_sum += plain.level(0).GetEdgeSharpness(e);
    sum += cornered.level(0).GetEdgeSharpness(e);
  }
  EXPECT_EQ(plain_sum, 0.0f);
  EXPECT_EQ(sum, 2.5f);
  EXPECT_LT(plain.level(0).GetVertexSharpness(0), kInfiniteSharpness);
  EXPECT_GE(cornered.level(0).GetVertexSharpness(0), kInfiniteSharpness);
  EXPECT_LT(cornered.level(0).GetVertexSharpness(1), kInfiniteSharpness);
}

}  // namespace
}  // namespace planish

namespace planish::test {
namespace {

// The tables against explicit subdivision that knows no masks.

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

// What the iterations rely on, against dense linear algebra.

struct System {
  Eigen::MatrixXd matrix;
  Spectrum spectrum;
  std::vector<double> weights;
};

System system_of(const PolygonMesh& mesh, PrimalScheme scheme) {
  PrimalSplit split(mesh, {scheme, {}});
  split.refine(1);
  const auto table = primal_limit_masks(split);
  const StencilView<double> view = table.view();
  System system;
  system.matrix = Eigen::MatrixXd::Zero(view.row_count(), view.row_count());
  for (int32_t row = 0; row < view.row_count(); ++row) {
    for (int32_t k = view.offsets[row]; k < view.offsets[row] + view.sizes[row]; ++k) {
      system.matrix(row, view.indices[k]) += view.weights[k];
    }
  }
  system.spectrum = primal_spectrum(split, view);
  system.weights = primal_row_weights(split);
  return system;
}

class PrimalSpectrum : public testing::TestWithParam<PrimalScheme> {};

TEST_P(PrimalSpectrum, IsBoundedAsClaimed) {
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    SCOPED_TRACE(name);
    const System system = system_of(mesh, GetParam());
    const Eigen::VectorXcd values = system.matrix.eigenvalues();
    const double smallest = values.real().minCoeff();
    const double imaginary = values.imag().cwiseAbs().maxCoeff();
    EXPECT_LT(values.real().maxCoeff(), 1 + 1e-9);
    if (system.spectrum.proven) {
      EXPECT_GE(smallest, system.spectrum.smallest - 1e-9);
      EXPECT_LT(imaginary, 1e-6);
    }
    // Darts and semi-sharp edges tie a curve to the faces beside it and not the other way round.
    EXPECT_LT(imaginary, 0.05);
    if (system.spectrum.smallest > 0.01) {
      EXPECT_GT(smallest, 0);
    }
    if (system.spectrum.self_adjoint) {
      const Eigen::VectorXd weights =
          Eigen::Map<const Eigen::VectorXd>(system.weights.data(), system.matrix.rows());
      const Eigen::MatrixXd scaled = weights.asDiagonal() * system.matrix;
      EXPECT_LT((scaled - scaled.transpose()).cwiseAbs().maxCoeff(), 1e-12);
      if (!system.spectrum.proven) {
        EXPECT_NEAR(smallest, system.spectrum.smallest, 0.02);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, PrimalSpectrum, testing::ValuesIn(kBothPrimalSchemes),
                         [](const auto& test) {
                           return test.param == PrimalScheme::Loop ? "Loop" : "CatmullClark";
                         });

// Eigenvalues 0, 1/6, 1/2 and 1.
TEST(Spectrum, CatmullClarkIsSingularOnTheCube) {
  const System system = system_of(cube(), PrimalScheme::CatmullClark);
  EXPECT_NEAR(system.spectrum.smallest, 0, 1e-12);
  EXPECT_FALSE(system.spectrum.proven);
}

TEST(Spectrum, RegularMeshesMeetTheBound) {
  const System quads = system_of(torus(12, 12, 1, 0.4), PrimalScheme::CatmullClark);
  EXPECT_NEAR(quads.spectrum.smallest, 1.0 / 9, 1e-12);
  EXPECT_NEAR(quads.matrix.eigenvalues().real().minCoeff(), 1.0 / 9, 1e-9);
  const System triangles = system_of(as_triangles(torus(12, 12, 1, 0.4)), PrimalScheme::Loop);
  EXPECT_NEAR(triangles.spectrum.smallest, 1.0 / 4, 1e-12);
  EXPECT_NEAR(triangles.matrix.eigenvalues().real().minCoeff(), 1.0 / 4, 1e-9);
}

}  // namespace
}  // namespace planish::test
