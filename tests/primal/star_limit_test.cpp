#include "planish/primal/primal_stencils.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/meshes.h"

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

}  // namespace
}  // namespace planish
