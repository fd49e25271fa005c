#include "planish/measure/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "planish/measure/vertex_fields.h"
#include "planish/surface/surface_blocks.h"
#include "support/meshes.h"

namespace planish {
namespace {

struct Tessellated {
  Tessellated(const PolygonMesh& mesh, int level)
      : surface(mesh, EvaluateOptions{}), tessellation(collect(*surface.level(level), {})) {}

  [[nodiscard]] Curvatures exact(float mean = -7, float gaussian = -7) const {
    Curvatures elsewhere;
    elsewhere.mean.assign(tessellation.positions.size(), mean);
    elsewhere.gaussian.assign(tessellation.positions.size(), gaussian);
    return curvatures_of_derivatives(surface, tessellation, std::move(elsewhere));
  }

  DooSabinSurface surface;
  SurfaceMesh tessellation;
};

// One quadratic polynomial everywhere: z = (a x^2 + b y^2) / 2 over a grid of units, whose B-spline
// has exactly those second derivatives.
TEST(DerivativeCurvatures, AreThoseOfAParaboloid) {
  constexpr double kA = 0.3, kB = -0.2;
  constexpr int kSize = 8;
  PolygonMesh mesh = test::flat_grid(kSize, kSize);
  for (glm::dvec3& p : mesh.positions) {
    p.z = 0.5 * (kA * p.x * p.x + kB * p.y * p.y);
  }
  for (const int level : {0, 1, 2, 4}) {
    const Tessellated c(mesh, level);
    const Curvatures curvatures = c.exact();
    glm::dvec3 low = mesh.positions.front(), high = low;
    for (const glm::dvec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
    std::int64_t inside = 0;
    for (std::size_t v = 0; v < curvatures.mean.size(); ++v) {
      const glm::dvec3 p = c.tessellation.positions[v];
      // Two faces from the boundary, whose curves are polynomials of their own.
      if (p.x < low.x + 2.1 || p.x > high.x - 2.1 || p.y < low.y + 2.1 || p.y > high.y - 2.1)
        continue;
      ++inside;
      const double zx = kA * p.x, zy = kB * p.y, w = 1 + zx * zx + zy * zy;
      const double sign = c.tessellation.normals[v].z > 0 ? -1 : 1;
      const double mean = sign * 0.5 * ((1 + zy * zy) * kA + (1 + zx * zx) * kB) / std::pow(w, 1.5);
      ASSERT_NEAR(curvatures.gaussian[v], kA * kB / (w * w), 1e-6) << level << " " << v;
      ASSERT_NEAR(curvatures.mean[v], mean, 1e-6) << level << " " << v;
    }
    EXPECT_GT(inside, 8);
  }
}

// Where valence and size are 4 there is a polynomial; elsewhere what was given stays.
TEST(DerivativeCurvatures, LeaveExtraordinaryPlacesAlone) {
  const PolygonMesh mesh = test::cube();  // valence 3 at every vertex, faces of 4
  const Curvatures curvatures = Tessellated(mesh, 2).exact(-7, -8);
  for (std::size_t v = 0; v < curvatures.mean.size(); ++v) {
    EXPECT_EQ(curvatures.mean[v] == -7, v < 8) << v;
    EXPECT_EQ(curvatures.gaussian[v] == -8, v < 8) << v;
  }
}

TEST(DerivativeCurvatures, AreWhatNormalsApproach) {
  const PolygonMesh mesh = test::torus(24, 12, 2, 1);
  double last = 1e9;
  for (const int level : {2, 3, 4}) {
    const Tessellated c(mesh, level);
    const Curvatures exact = c.exact(), normals = curvatures_of_normals(c.tessellation);
    double sum = 0;
    for (std::size_t v = 0; v < exact.mean.size(); ++v) {
      ASSERT_NE(exact.mean[v], -7.0f);
      sum += std::abs(exact.mean[v] - normals.mean[v]);
    }
    const double mean_gap = sum / static_cast<double>(exact.mean.size());
    EXPECT_LT(mean_gap, 0.6 * last);
    last = mean_gap;
  }
  EXPECT_LT(last, 0.01);
}

TEST(DerivativeCurvatures, ScaleWithTheModel) {
  PolygonMesh mesh = test::torus(12, 8, 2, 1);
  const Curvatures small = Tessellated(mesh, 1).exact();
  for (glm::dvec3& p : mesh.positions) p *= 10;
  const Curvatures large = Tessellated(mesh, 1).exact();
  for (std::size_t v = 0; v < small.mean.size(); ++v) {
    EXPECT_NEAR(small.mean[v], 10 * large.mean[v], 1e-6);
    EXPECT_NEAR(small.gaussian[v], 100 * large.gaussian[v], 1e-5);
  }
}

TEST(DerivativeCurvatures, AreNamedByTheFields) {
  const PolygonMesh mesh = test::torus(12, 8, 2, 1);
  const Tessellated c(mesh, 1);
  const VertexFields fields = vertex_fields(c.tessellation, mesh, 1, &c.surface);
  EXPECT_STREQ(name_of(fields.curvature_source), "second derivatives");
  EXPECT_EQ(fields.curvatures.mean, c.exact().mean);
  EXPECT_STREQ(name_of(vertex_fields(c.tessellation, mesh, 1).curvature_source), "normals");
}

}  // namespace
}  // namespace planish
