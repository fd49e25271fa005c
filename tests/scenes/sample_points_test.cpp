#include "make_scenes/sample_points.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "planish/files/mesh_file.h"
#include "planish/reconstruct/point_tree.h"

namespace planish::shapes {
namespace {

// Two triangles, one of nine times the other's area.
PolygonMesh two_triangles() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {10, 0, 1}, {11, 0, 1}, {10, 1, 1}};
  mesh.add_face(std::vector<std::int32_t>{0, 1, 2});
  mesh.add_face(std::vector<std::int32_t>{3, 4, 5});
  return mesh;
}

TEST(SamplePoints, DrawsEvenlyInArea) {
  int small = 0;
  for (const glm::dvec3& p : sample_uniform(two_triangles(), 20000, 1)) {
    small += p.z > 0.5;
    const glm::dvec3 foot = p.z > 0.5 ? p - glm::dvec3(10, 0, 1) : p;
    EXPECT_GE(foot.x, 0);
    EXPECT_GE(foot.y, 0);
    EXPECT_LE(foot.x + foot.y, (p.z > 0.5 ? 1 : 3) + 1e-12);
  }
  EXPECT_NEAR(small, 2000, 5 * 43);  // five standard deviations
}

TEST(SamplePoints, KeepsPoissonDisksApart) {
  const std::vector<glm::dvec3> points = sample_poisson_disk(two_triangles(), 2000, 3);
  ASSERT_EQ(points.size(), 2000u);
  const PointTree tree(points);
  double nearest = 1e9;
  for (const glm::dvec3& p : points) {
    std::array<Neighbour, 2> found;
    ASSERT_EQ(tree.find_nearest(p, found), 2u);
    nearest = std::min(nearest, found[1].squared_distance);
  }
  // Area 5 for 2000 points: squares of side 0.05.
  EXPECT_GT(std::sqrt(nearest), 0.7 * 0.05);
}

TEST(SamplePoints, IsTheSameForTheSameSeed) {
  EXPECT_EQ(sample_poisson_disk(two_triangles(), 300, 5),
            sample_poisson_disk(two_triangles(), 300, 5));
  EXPECT_NE(sample_uniform(two_triangles(), 300, 5), sample_uniform(two_triangles(), 300, 6));
}

TEST(SamplePoints, AddsNoiseAndOutliers) {
  std::vector<glm::dvec3> points(5000, glm::dvec3(0.0));
  add_noise(points, 0.1, 2);
  double squares = 0;
  for (const glm::dvec3& p : points) squares += glm::dot(p, p);
  EXPECT_NEAR(std::sqrt(squares / 15000), 0.1, 0.003);
  add_outliers(points, 50, 2);
  EXPECT_EQ(points.size(), 5050u);
}

TEST(SamplePoints, WritesPly) {
  const std::vector<glm::dvec3> points = {{0.5, -2, 3}, {4, 5, 6}};
  const std::string text = ply_text(points);
  const MeshFile file =
      read_mesh(std::as_bytes(std::span(text.data(), text.size())), "a.ply", FileFormat::Ply);
  EXPECT_EQ(file.mesh.positions, points);
}

}  // namespace
}  // namespace planish::shapes
