#include "planish/reconstruct/spatial_search.h"

#include <gtest/gtest.h>

#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

TEST(TriangleShape, MeasuresEveryRegion) {
  std::mt19937_64 random(9);
  const auto place = [&] {
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    return glm::dvec3(unit(), unit(), unit());
  };
  for (int i = 0; i < 20000; ++i) {
    const std::array<glm::dvec3, 3> t = {place(), place(), place()};
    const glm::dvec3 p = 3.0 * place() - 1.0;
    EXPECT_NEAR(TriangleShape(t[0], t[1], t[2]).squared_distance(p), test::squared_distance(p, t),
                1e-9);
  }
}

TEST(TriangleShape, ManyPointsAtOnceAreAsOneByOne) {
  const std::vector<glm::dvec3> places = test::torus_points(300, 6);
  PointBatch batch;
  std::vector<double> squared(kPointLanes, INFINITY);
  std::vector<std::int32_t> nearest(kPointLanes, -1);
  for (int i = 0; i < kPointLanes; ++i) {
    const glm::dvec3& p = places[i];
    batch.x[i] = p.x, batch.y[i] = p.y, batch.z[i] = p.z;
    batch.squared_distance[i] = INFINITY;
    batch.nearest[i] = -1;
  }
  for (std::int32_t s = 0; s < 50; ++s) {
    const auto corner = [&](std::int32_t k) { return places[200 + s + k]; };
    // Every fifth has no area.
    const TriangleShape shape(corner(0), corner(1), s % 5 == 0 ? corner(1) : corner(2));
    take_nearer(shape, s, kPointLanes, batch);
    for (std::size_t i = 0; i < squared.size(); ++i)
      if (const double d = shape.squared_distance(places[i]); d < squared[i])
        squared[i] = d, nearest[i] = s;
  }
  EXPECT_EQ(std::vector(batch.squared_distance, batch.squared_distance + kPointLanes), squared);
  EXPECT_EQ(std::vector(batch.nearest, batch.nearest + kPointLanes), nearest);
}

TEST(TriangleShape, TakesNeedles) {
  const glm::dvec3 a(0, 0, 0), b(1, 0, 0), c(3, 0, 0);
  EXPECT_DOUBLE_EQ(TriangleShape(a, b, c).squared_distance({2, 1, 0}), 1);
  EXPECT_DOUBLE_EQ(TriangleShape(a, a, a).squared_distance({2, 1, 0}), 5);
}

TEST(TriangleTree, FindsWhatTryingEveryTriangleFinds) {
  const test::TriangleMesh torus = test::torus_mesh(24, 16);
  const TriangleTree tree(torus.positions, torus.triangles);
  for (const glm::dvec3& p : test::torus_points(500, 4)) {
    double best = INFINITY;
    for (const Triangle& t : torus.triangles)
      best = std::fmin(
          best, test::squared_distance(
                    p, {torus.positions[t[0]], torus.positions[t[1]], torus.positions[t[2]]}));
    const TriangleTree::Hit hit = tree.nearest(p);
    EXPECT_NEAR(hit.squared_distance, best, 1e-14);
    ASSERT_GE(hit.triangle, 0);
  }
  EXPECT_EQ(TriangleTree({}, {}).nearest({0, 0, 0}).triangle, -1);
}

TEST(MeasureDistances, GivesMaximumRmsAndPlace) {
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const std::vector<glm::dvec3> points = {{1, 1, 0}, {1, 1, -4}, {-3, 0, 0}};
  const PointDistances distances = measure_distances(points, positions, triangles);
  EXPECT_DOUBLE_EQ(distances.max, 4);
  EXPECT_DOUBLE_EQ(distances.rms, 5 / std::sqrt(3.0));
  EXPECT_EQ(distances.farthest, 1);
}

}  // namespace
}  // namespace planish
