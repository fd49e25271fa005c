#include "planish/reconstruct/reconstruct_steps.h"

#include <gtest/gtest.h>

#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

std::vector<glm::dvec3> noisy_torus(double deviation) {
  std::vector<glm::dvec3> points = test::torus_points(8000, 11);
  std::mt19937_64 random(2);
  for (glm::dvec3& p : points) {
    const double around = std::hypot(p.x, p.y);
    const glm::dvec3 ring(p.x / around, p.y / around, 0);
    double sum = -6;  // of twelve uniform numbers: deviation 1
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() >> 11) * 0x1p-53;
    p += deviation * sum * glm::normalize(p - ring);
  }
  return points;
}

double rms_distance(const std::vector<glm::dvec3>& points) {
  double sum = 0;
  for (const glm::dvec3& p : points) sum += test::distance_to_torus(p) * test::distance_to_torus(p);
  return std::sqrt(sum / static_cast<double>(points.size()));
}

TEST(SmoothPoints, LeavesAQuadricWhereItIs) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) {
      const double x = 0.1 * i + 0.01 * (j % 3), y = 0.1 * j;
      points.emplace_back(x, y, 2 + x - y);
    }
  const auto smooth = smooth_points(points, 2);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(glm::distance(points[i], smooth[i]), 1e-12);
}

TEST(SmoothPoints, TakesNoiseAway) {
  const auto points = noisy_torus(0.01);
  EXPECT_NEAR(rms_distance(points), 0.01, 5e-4);
  EXPECT_LT(rms_distance(smooth_points(points, 2)), 0.006);
}

TEST(SmoothPoints, MeasuresTheNoise) {
  EXPECT_NEAR(measure_noise(noisy_torus(0.01)), 0.01, 0.0015);
  EXPECT_LT(measure_noise(noisy_torus(0)), 0.001);
}

TEST(SmoothPoints, TakesNoShapeForNoise) {
  // As coarse as that, quadratics follow neither an edge nor a narrow tube.
  EXPECT_EQ(measure_noise(test::torus_points(300, 3)), 0);
  std::vector<glm::dvec3> ridge;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j) ridge.emplace_back(i, j + 0.3 * (i % 2), 3 * std::abs(j % 8 - 4));
  EXPECT_EQ(measure_noise(ridge), 0);
}

TEST(SmoothPoints, LeavesEdgesToWhoKnowsTheNoise) {
  std::mt19937_64 random(7);
  std::vector<glm::dvec3> roof;
  for (int i = 0; i < 60; ++i)
    for (int j = -30; j <= 30; ++j)
      roof.emplace_back(
          i + 0.1 * (j % 3), j,
          -std::abs(j) + 0.05 * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5));
  const auto ridge_height = [&](const std::vector<glm::dvec3>& points) {
    double sum = 0;
    for (int i = 10; i < 50; ++i) sum += points[i * 61 + 30].z;
    return sum / 40;
  };
  EXPECT_LT(ridge_height(smooth_points(roof, 2)), -0.2);
  EXPECT_GT(ridge_height(smooth_points(roof, 2, 0.0144)), -0.01);
}

TEST(SmoothPoints, TakesDegenerateClouds) {
  const std::vector<glm::dvec3> same(50, glm::dvec3(1, 2, 3));
  EXPECT_EQ(smooth_points(same, 1), same);
  EXPECT_TRUE(smooth_points({}, 3).empty());
  std::vector<glm::dvec3> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(i, 0, 0);
  EXPECT_EQ(smooth_points(line, 1), line);
  EXPECT_EQ(measure_noise(line), 0);
}

}  // namespace
}  // namespace planish
