#include "planish/mesh/face_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

namespace planish {
namespace {

using glm::dvec2;

double doubled_area(const dvec2& a, const dvec2& b, const dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// A band of width 0.3 along three quarters of a circle, finely drawn on both sides.
std::vector<dvec2> band(int corners) {
  std::vector<dvec2> polygon;
  const int half = corners / 2;
  for (int i = 0; i < 2 * half; ++i) {
    const bool is_outer = i < half;
    const double along = static_cast<double>(is_outer ? i : 2 * half - 1 - i) / (half - 1);
    const double angle = 1.5 * std::numbers::pi * along, radius = is_outer ? 1 : 0.7;
    polygon.push_back(radius * dvec2(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

TEST(EarClipping, CoversThePolygonOnce) {
  const std::vector<dvec2> polygon = band(500);
  double area = 0, of_triangles = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    area += doubled_area(polygon[0], polygon[i], polygon[i + 1]);
  const auto triangles = clip_ears(polygon);
  ASSERT_EQ(triangles.size(), polygon.size() - 2);
  for (const auto& [a, b, c] : triangles) {
    const double own = doubled_area(polygon[a], polygon[b], polygon[c]);
    EXPECT_GT(own, 0);
    of_triangles += own;
  }
  EXPECT_NEAR(of_triangles, area, 1e-12);
}

// Chords of the outer side reach up to 1.4.
TEST(EarClipping, CutsABandAcross) {
  for (const int corners : {100, 1000, 10'000}) {
    const std::vector<dvec2> polygon = band(corners);
    double longest = 0;
    for (const auto& triangle : clip_ears(polygon))
      for (std::size_t k = 0; k < 3; ++k)
        longest =
            std::max(longest, glm::distance(polygon[triangle[k]], polygon[triangle[(k + 1) % 3]]));
    EXPECT_LT(longest, 0.36) << corners;
  }
}

// Every second corner first: a disc gets no fan, whose triangles are slivers.
TEST(EarClipping, HalvesARoundPolygonAgainAndAgain) {
  constexpr int kCorners = 256;
  std::vector<dvec2> polygon;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    polygon.emplace_back(3 * std::cos(angle), 3 * std::sin(angle));
  }
  std::vector<int> of_corner(kCorners, 0);
  for (const auto& triangle : clip_ears(polygon))
    for (const std::uint32_t corner : triangle) ++of_corner[corner];
  EXPECT_LE(*std::max_element(of_corner.begin(), of_corner.end()), 20);
}

TEST(EarClipping, ReturnsAsManyTrianglesOfPolygonsThatCrossThemselves) {
  const std::vector<dvec2> bow = {{0, 0}, {2, 2}, {2, 0}, {0, 2}, {1, 3}, {-1, 3}};
  EXPECT_EQ(clip_ears(bow).size(), bow.size() - 2);
  const std::vector<dvec2> point(50, dvec2(1, 1));
  EXPECT_EQ(clip_ears(point).size(), point.size() - 2);
}

}  // namespace
}  // namespace planish
