#include "planish/mend/faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "planish/core/work.h"
#include "planish/mesh/face_geometry.h"
#include "support/outlines.h"

namespace planish::test {
namespace {

using glm::dvec2;
using std::numbers::pi;

double area_of(const Outline& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i)
    sum += cross(outline[i], outline[(i + 1) % outline.size()]);
  return sum;
}

std::vector<std::size_t> all_corners(const Outline& outline) {
  std::vector<std::size_t> part(outline.size());
  std::iota(part.begin(), part.end(), std::size_t{0});
  return part;
}

TEST(CornerSwirl, IsNoneOfAffineRegularPolygons) {
  for (const int n : {3, 4, 33, 1000}) {
    Outline outline;
    for (int i = 0; i < n; ++i) {
      const dvec2 p(std::cos(2 * pi * i / n), std::sin(2 * pi * i / n));
      outline.emplace_back(5 + 3 * p.x + p.y, 0.1 * p.y - 2);
    }
    EXPECT_LT(corner_swirl(outline), 1e-9) << n;
    EXPECT_EQ(corner_swirl(Outline(outline.rbegin(), outline.rend())), n / 2.0);
  }
}

// Angles moved by a wave that leaves the first Fourier pair as it was, up to the wave's square.
TEST(CornerSwirl, CountsCorners) {
  constexpr int kCorners = 1000;
  constexpr double kMoved = 1e-3;
  Outline outline;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * pi * i / kCorners, at = angle + kMoved * std::sin(3 * angle);
    outline.emplace_back(std::cos(at), std::sin(at));
  }
  EXPECT_NEAR(corner_swirl(outline), kMoved * kCorners / (2 * pi), 1e-3);
}

std::vector<std::pair<const char*, Outline>> outlines() {
  return {{"rounded square", rounded_square(100, 0.5)},
          {"square with small arcs", rounded_square(64, 0.1)},
          {"slot", slot(100, 4)},
          {"half disc", pie_slice(300, 180)},
          {"pie slice", pie_slice(100, 20)},
          {"two corners", pie_slice(500, 90)}};
}

// Every side of the polygon belongs to one part, every diagonal to two, none of them crosses.
TEST(EvenParts, AreThePolygon) {
  for (const auto& [name, outline] : outlines()) {
    SCOPED_TRACE(name);
    ASSERT_GT(corner_swirl(outline), kMostSwirl);
    std::map<std::pair<std::size_t, std::size_t>, int> asked;
    const auto parts = even_parts(outline, all_corners(outline), [&](std::size_t a, std::size_t b) {
      ++asked[std::minmax(a, b)];
      return true;
    });
    std::map<std::pair<std::size_t, std::size_t>, int> edges;
    double sum = 0;
    for (const auto& part : parts) {
      Outline places;
      for (const std::size_t corner : part) places.push_back(outline[corner]);
      EXPECT_LE(corner_swirl(places), kMostSwirl);
      EXPECT_GT(area_of(places), 0);
      sum += area_of(places);
      for (std::size_t i = 0; i < part.size(); ++i)
        ++edges[std::minmax(part[i], part[(i + 1) % part.size()])];
    }
    EXPECT_NEAR(sum, area_of(outline), 1e-9 * sum);
    EXPECT_LE(parts.size(), outline.size());
    EXPECT_EQ(asked.size(), parts.size() - 1);
    for (const auto& [edge, count] : edges) {
      const std::size_t apart = edge.second - edge.first;
      const bool is_side = apart == 1 || apart == outline.size() - 1;
      EXPECT_EQ(count, is_side ? 1 : 2);
      EXPECT_EQ(asked.contains(edge), !is_side);
    }
  }
}

TEST(EvenParts, AreMostlyQuadsBetweenFinelyDrawnSides) {
  for (const Outline& outline : {rounded_square(100, 0.5), slot(100, 4), pie_slice(300, 180)}) {
    const auto parts =
        even_parts(outline, all_corners(outline), [](std::size_t, std::size_t) { return true; });
    const auto quads =
        std::ranges::count_if(parts, [](const auto& part) { return part.size() == 4; });
    EXPECT_GT(4 * quads, 3 * std::ssize(parts));
  }
}

TEST(EvenParts, TakeFewQuestions) {
  const auto asked = [](const Outline& outline) {
    const auto& count = work_counts[static_cast<std::size_t>(Work::Pairs)];
    const std::int64_t before = count;
    (void)even_parts(outline, all_corners(outline), [](std::size_t, std::size_t) { return true; });
    return static_cast<double>(count - before) / static_cast<double>(outline.size());
  };
  for (const int steps : {500, 5000}) {
    EXPECT_LT(asked(rounded_square(steps, 0.5)), 200) << steps;
    EXPECT_LT(asked(slot(steps, 4)), 200) << steps;
    EXPECT_LT(asked(pie_slice(4 * steps, 90)), 200) << steps;
  }
}

TEST(EvenParts, StayWholeWhereNothingMayCut) {
  const Outline outline = slot(100, 4);
  const auto parts =
      even_parts(outline, all_corners(outline), [](std::size_t, std::size_t) { return false; });
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].size(), outline.size());
}

}  // namespace
}  // namespace planish::test
