#include "planish/mesh/point_cloud.h"
#include "planish/files/read_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <random>

#include "mesh/test_meshes.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::ElementsAre;

TEST(PointCloud, KnowsFormatsByExtension) {
  EXPECT_EQ(format_of("a/b.PCD"), FileFormat::Pcd);
  EXPECT_EQ(format_of("b.pts"), FileFormat::Pts);
  EXPECT_FALSE(serves(format_of("b.obj").value(), FormatUse::ReadPoints));
  EXPECT_EQ(name_of(FileFormat::Xyz), "xyz");
}

TEST(PointCloud, ReadsPlyWithoutFaces) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nproperty float nx\nend_header\n0.1 2 3 0\n4 5 6 1\n";
  EXPECT_THAT(read_points(test::bytes_of(text), "a.ply", FileFormat::Ply).points,
              ElementsAre(glm::dvec3(0.1, 2, 3), glm::dvec3(4, 5, 6)));
}

TEST(PointCloud, RefusesCoordinatesThatOverflowWhenSquared) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nend_header\n0 0 0\n0 1e160 0\n";
  EXPECT_THAT(
      test::message_of(ErrorCode::UnreadableInput,
                       [&] { (void)read_points(test::bytes_of(text), "a.ply", FileFormat::Ply); }),
      testing::HasSubstr("a.ply: point 1 of 2: a coordinate is beyond 1e150"));
}

TEST(PointCloud, ShiftsFarCloudsExactly) {
  std::mt19937_64 random(3);
  std::vector<glm::dvec3> places;
  for (int i = 0; i < 1000; ++i) {
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    places.emplace_back(500000 + 3 * unit(), -5.4e6 + 7 * unit(), unit() - 0.5);
  }
  PointCloud cloud{.points = places};
  recentre(cloud);
  EXPECT_GT(std::abs(cloud.origin.x), 499999);
  EXPECT_EQ(cloud.origin.z, 0);  // not far on this axis
  EXPECT_LT(diagonal_of(cloud.points), 8);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_LT(std::abs(cloud.points[i].x) + std::abs(cloud.points[i].y), 32);
    const glm::dvec3 back = cloud.origin + cloud.points[i];
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(std::bit_cast<std::uint64_t>(back[axis]),
                std::bit_cast<std::uint64_t>(places[i][axis]));
  }
}

TEST(PointCloud, LeavesNearClouds) {
  PointCloud cloud{.points = {{0.1, 0.2, 0.3}, {1, 1, 1}}};
  recentre(cloud);
  EXPECT_EQ(cloud.origin, glm::dvec3(0.0));
  EXPECT_EQ(cloud.points[0], glm::dvec3(0.1, 0.2, 0.3));
}

}  // namespace
}  // namespace planish
