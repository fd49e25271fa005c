#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

using ::testing::ElementsAre;

// Twice the signed area seen from +z.
double doubled_triangle_area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

std::vector<std::uint32_t> triangles_of(const std::vector<glm::dvec3>& polygon) {
  std::vector<std::int32_t> corners(polygon.size());
  std::iota(corners.begin(), corners.end(), 0);
  std::vector<std::uint32_t> triangles(3 * (polygon.size() - 2));
  triangulate(corners, polygon, triangles);
  return triangles;
}

// A triangulation covers a counter-clockwise polygon without overlap exactly when all triangles
// turn left and their areas sum to the polygon's.
void expect_cover(const std::vector<glm::dvec3>& polygon) {
  double area = 0, covered = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    area += doubled_triangle_area(glm::dvec3(0), polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  const auto triangles = triangles_of(polygon);
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const double part = doubled_triangle_area(polygon[triangles[t]], polygon[triangles[t + 1]],
                                              polygon[triangles[t + 2]]);
    EXPECT_GE(part, 0.0) << "triangle " << t / 3 << " is turned over";
    covered += part;
  }
  EXPECT_GT(area, 0.0);
  EXPECT_NEAR(covered, area, 1e-12 * area);
}

TEST(SplitQuad, TakesTheShorterDiagonal) {
  const glm::dvec3 a(0, 0, 0), b(2, 0.5, 0), c(2, 1, 0), d(0, 1, 0);
  ASSERT_LT(glm::distance(b, d), glm::distance(a, c));
  EXPECT_THAT(split_quad(a, b, c, d), ElementsAre(0, 1, 3, 1, 2, 3));
  EXPECT_THAT(split_quad(b, c, d, a), ElementsAre(0, 1, 2, 0, 2, 3));
}

TEST(SplitQuad, EqualDiagonalsGoFromTheFirstCorner) {
  const glm::dvec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 0);
  EXPECT_THAT(split_quad(a, b, c, d), ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_THAT(split_quad(b, c, d, a), ElementsAre(0, 1, 2, 0, 2, 3));
  // Rounding must not decide.
  EXPECT_THAT(split_quad(a, b, c + glm::dvec3(1e-9, 0, 0), d), ElementsAre(0, 1, 2, 0, 2, 3));
}

TEST(SplitQuad, ConcaveQuadIsSplitAtItsReflexCorner) {
  // Corner 2 is the reflex one; the diagonal 1-3 is shorter but lies outside.
  const std::vector<glm::dvec3> dart{{0, 0, 0}, {1, 4, 0}, {0, 3, 0}, {-1, 4, 0}};
  ASSERT_LT(glm::distance(dart[1], dart[3]), glm::distance(dart[0], dart[2]));
  EXPECT_THAT(split_quad(dart[0], dart[1], dart[2], dart[3]), ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_THAT(split_quad(dart[3], dart[0], dart[1], dart[2]), ElementsAre(0, 1, 3, 1, 2, 3));
  expect_cover(dart);
}

TEST(Triangulate, ConvexPolygonsOfEverySizeAreCovered) {
  EXPECT_THAT(triangles_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), ElementsAre(0, 1, 2));
  for (int n = 3; n <= 70; ++n) {
    std::vector<glm::dvec3> polygon;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      polygon.emplace_back(3 + std::cos(angle), 2 + std::sin(angle), 0);
    }
    expect_cover(polygon);
  }
}

TEST(Triangulate, ConcavePolygonsAreCovered) {
  // Corners on its edges.
  expect_cover({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {3, 3, 0}, {1.5, 3, 0}, {0, 3, 0}});
  expect_cover({{0, 0, 0}, {4, 0, 0}, {4, 1, 0}, {1, 1, 0}, {1, 4, 0}, {0, 4, 0}});  // L
  expect_cover({{0, 0, 0},
                {5, 0, 0},
                {5, 4, 0},
                {4, 4, 0},
                {4, 1, 0},
                {3, 1, 0},
                {3, 4, 0},
                {2, 4, 0},
                {2, 1, 0},
                {1, 1, 0},
                {1, 4, 0},
                {0, 4, 0}});  // comb
}

double unit_number(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

std::vector<glm::dvec3> star_polygon(int count, std::mt19937& random) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count, radius = 0.05 + unit_number(random);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return points;
}

TEST(Triangulate, RandomStarsAreCovered) {
  std::mt19937 random(20);
  for (int round = 0; round < 200; ++round)
    expect_cover(star_polygon(5 + static_cast<int>(random() % 40), random));
}

// The rule itself, in the time of its square: from corner 1 on the next corner whose triangle holds
// no corner that turned inward, then the second behind it.
std::vector<std::uint32_t> plainly_clipped(const std::vector<glm::dvec3>& polygon) {
  std::vector<std::uint32_t> left(polygon.size()), triangles;
  std::iota(left.begin(), left.end(), 0u);
  const auto beside = [&](std::size_t k, std::size_t by) { return left[(k + by) % left.size()]; };
  const auto area = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return doubled_triangle_area(polygon[a], polygon[b], polygon[c]);
  };
  const auto convex = [&](std::size_t k) {
    return area(beside(k, left.size() - 1), left[k], beside(k, 1)) > 0;
  };
  std::vector<bool> reflex(polygon.size());
  for (std::size_t k = 0; k < left.size(); ++k) reflex[k] = !convex(k);
  const auto is_ear = [&](std::size_t k) {
    if (!convex(k)) return false;
    const std::uint32_t a = beside(k, left.size() - 1), b = left[k], c = beside(k, 1);
    return std::ranges::none_of(left, [&](std::uint32_t p) {
      if (!reflex[p] || polygon[p] == polygon[a] || polygon[p] == polygon[b] ||
          polygon[p] == polygon[c])
        return false;
      return area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0;
    });
  };
  // Radius of the circle and length of the diagonal, to 2 and 12 bits, and the corner itself.
  const auto rank = [&](std::size_t k) {
    const glm::dvec3 &a = polygon[beside(k, left.size() - 1)], &b = polygon[left[k]],
                     &c = polygon[beside(k, 1)];
    const double diagonal = glm::distance(a, c);
    const double radius =
        glm::distance(a, b) * glm::distance(b, c) * diagonal / (2 * doubled_triangle_area(a, b, c));
    const auto rounded = [](double size, double steps) {
      int octave = 0;
      const double part = std::frexp(static_cast<double>(static_cast<float>(size)), &octave);
      return std::pair(size > 0 ? octave : -1000, std::floor(2 * part * steps + 0.5) / steps);
    };
    const auto octaves = [](std::pair<int, double> size) {
      return size.second == 2 ? std::pair(size.first + 1, 1.0) : size;
    };
    return std::tuple(octaves(rounded(radius, 4)), octaves(rounded(diagonal, 4096)), left[k]);
  };
  for (std::size_t k = 0; left.size() > 2;) {
    std::size_t best = left.size();
    for (std::size_t ear = 0; ear < left.size(); ++ear)
      if (is_ear(ear) && (best == left.size() || rank(ear) < rank(best))) best = ear;
    if (best < left.size()) k = best;
    triangles.insert(triangles.end(), {beside(k, left.size() - 1), left[k], beside(k, 1)});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
    const std::size_t before = (k + left.size() - 1) % left.size();
    k = k % left.size();
    for (const std::size_t other : {before, k})
      if (convex(other)) reflex[left[other]] = false;
  }
  return triangles;
}

// A band along a spiral.
std::vector<glm::dvec3> spiral_polygon(int count, double step) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 2 * count; ++i) {
    const double angle = step * (i < count ? i : 2 * count - 1 - i);
    const double radius = 1 + angle + (i < count ? 0.5 : 0);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return points;
}

std::vector<glm::dvec3> comb_polygon(int teeth) {
  std::vector<glm::dvec3> points{{0, -1, 0}, {2.0 * teeth, -1, 0}};
  for (int t = teeth; t-- > 0;) {
    points.emplace_back(2 * t + 1.5, 10.0 * teeth, 0);
    points.emplace_back(2 * t + 0.5, 0, 0);
  }
  return points;
}

TEST(Triangulate, LargePolygonsFallIntoTheTrianglesOfPlainClipping) {
  std::mt19937 random(7);
  for (int round = 0; round < 120; ++round) {
    const int n = 5 + static_cast<int>(random() % 300);
    const std::vector<glm::dvec3> star = star_polygon(n, random);
    ASSERT_EQ(triangles_of(star), plainly_clipped(star)) << n;
    std::vector<glm::dvec3> tangle;  // crosses itself, on a coarse grid
    for (int i = 0; i < n; ++i)
      tangle.emplace_back(std::floor(20 * unit_number(random)),
                          std::floor(20 * unit_number(random)), 0);
    double area = 0;  // seen from +z, as plain clipping sees it
    for (std::size_t i = 0; i < tangle.size(); ++i)
      area += doubled_triangle_area(glm::dvec3(0), tangle[i], tangle[(i + 1) % tangle.size()]);
    if (area < 0) std::ranges::reverse(tangle);
    if (area == 0) continue;
    ASSERT_EQ(triangles_of(tangle), plainly_clipped(tangle)) << n;
  }
  for (const auto& polygon :
       {spiral_polygon(200, 0.05), spiral_polygon(150, 0.3), comb_polygon(170)})
    ASSERT_EQ(triangles_of(polygon), plainly_clipped(polygon));
}

// Corners and boxes of them that were asked, for each corner.
double asked_in(const std::vector<glm::dvec3>& polygon) {
  return test::pairs_asked(polygon.size(), [&] { expect_cover(polygon); });
}

// All corners asked for each would be tens of thousands. It is the root of their number at most.
TEST(Triangulate, AHundredThousandCornersAskFewOthers) {
  std::mt19937 random(3);
  for (const int count : {10'000, 100'000}) {
    EXPECT_LT(asked_in(spiral_polygon(count / 2, 200.0 / count)), 1000) << count;
    EXPECT_LT(asked_in(comb_polygon(count / 2)), 100) << count;
    EXPECT_LT(asked_in(star_polygon(count, random)), 2500) << count;
  }
}

TEST(Triangulate, TiltedPolygonFarAwayIsSplitAsTheFlatOne) {
  const std::vector<glm::dvec3> flat{{0, 0, 0}, {4, 0, 0}, {4, 1, 0},
                                     {1, 1, 0}, {1, 4, 0}, {0, 4, 0}};
  // An exact rotation (3-4-5 about x) and a shift.
  std::vector<glm::dvec3> tilted;
  for (const auto& p : flat) {
    tilted.push_back(glm::dvec3(p.x, 0.6 * p.y - 0.8 * p.z, 0.8 * p.y + 0.6 * p.z) +
                     glm::dvec3(1e6, -2e6, 3e6));
  }
  // In the order in which ears are cut, which goes by sizes seen along an axis.
  const auto ascending = [](const std::vector<std::uint32_t>& corners) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t k = 0; k < corners.size(); k += 3)
      triangles.push_back({corners[k], corners[k + 1], corners[k + 2]});
    std::ranges::sort(triangles);
    return triangles;
  };
  EXPECT_EQ(ascending(triangles_of(tilted)), ascending(triangles_of(flat)));
}

TEST(Triangulate, PolygonsWithoutPlaneGetTheirTriangles) {
  // Crossing itself, folded to a line, all at one place: n - 2 triangles of its own corners.
  for (const std::vector<glm::dvec3>& polygon : std::vector<std::vector<glm::dvec3>>{
           {{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}, {-1, 1, 0}},
           {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},
           std::vector<glm::dvec3>(6, glm::dvec3(1, 2, 3))}) {
    const auto triangles = triangles_of(polygon);
    std::vector<int> uses(polygon.size());
    for (const std::uint32_t corner : triangles) {
      ASSERT_LT(corner, polygon.size());
      ++uses[corner];
    }
    for (const int count : uses) EXPECT_GE(count, 1);
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      EXPECT_NE(triangles[t], triangles[t + 1]);
      EXPECT_NE(triangles[t + 1], triangles[t + 2]);
      EXPECT_NE(triangles[t + 2], triangles[t]);
    }
  }
}

using glm::dvec2;

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
    area += doubled_triangle_area(polygon[0], polygon[i], polygon[i + 1]);
  const auto triangles = clip_ears(polygon);
  ASSERT_EQ(triangles.size(), polygon.size() - 2);
  for (const auto& [a, b, c] : triangles) {
    const double own = doubled_triangle_area(polygon[a], polygon[b], polygon[c]);
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
