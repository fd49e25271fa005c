#include "planish/files/mesh_file.h"
#include "planish/mesh/polygon_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "files/gltf/glb_bytes.h"
#include "mesh/test_meshes.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::ElementsAre;

TEST(PointCloud, KnowsFormatsByExtension) {
  EXPECT_EQ(format_of("a/b.PCD"), FileFormat::Pcd);
  EXPECT_EQ(format_of("b.pts"), FileFormat::Pts);
  EXPECT_FALSE(serves(format_of("b.stl").value(), FormatUse::ReadPoints));
  EXPECT_EQ(name_of(FileFormat::Xyz), "xyz");
}

TEST(PointCloud, ReadsPlyWithoutFaces) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
      "property double z\nproperty float nx\nend_header\n0.1 2 3 0\n4 5 6 1\n";
  EXPECT_THAT(read_points(test::bytes_of(text), "a.ply", FileFormat::Ply).points,
              ElementsAre(glm::dvec3(0.1, 2, 3), glm::dvec3(4, 5, 6)));
}

TEST(PointCloud, FurtherPropertiesOfPlyComeAlong) {
  const PointCloud cloud = read_points(
      test::bytes_of("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                     "property float y\nproperty float z\nproperty float nx\nproperty float ny\n"
                     "property float nz\nproperty uchar quality\nend_header\n"
                     "1 2 3 0 0 1 9\n4 5 6 0 0 1 7\n"),
      "a.ply", FileFormat::Ply);
  EXPECT_EQ(cloud.normals.size(), 2u);
  ASSERT_EQ(cloud.attributes.size(), 1u);
  EXPECT_EQ(cloud.attributes[0].name, "quality");
  EXPECT_THAT(cloud.attributes[0].values, ElementsAre(9, 7));
}

TEST(PointCloud, ReadsTheVerticesOfMeshFormats) {
  EXPECT_THAT(
      read_points(test::bytes_of("v 0.1 2 3\nv 4 5 6 0.5 0.5 0.5\n"), "a.obj", FileFormat::Obj)
          .points,
      ElementsAre(glm::dvec3(0.1, 2, 3), glm::dvec3(4, 5, 6)));
  EXPECT_THAT(
      read_points(test::bytes_of("OFF\n2 0 0\n0.1 2 3\n4 5 6\n"), "a.off", FileFormat::Off).points,
      ElementsAre(glm::dvec3(0.1, 2, 3), glm::dvec3(4, 5, 6)));
}

TEST(PointCloud, NormalsAndColoursComeAlong) {
  const PointCloud ply = read_points(
      test::bytes_of("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float "
                     "y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float "
                     "nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                     "end_header\n0 2 3 0 0 2 255 0 0\n4 5 6 nan 0 1 0 255 0\n"),
      "a.ply", FileFormat::Ply);
  ASSERT_EQ(ply.normals.size(), 2u);
  EXPECT_EQ(ply.normals[0], glm::vec3(0, 0, 2));
  EXPECT_EQ(ply.normals[1], glm::vec3(0, 0, 1));
  EXPECT_THAT(ply.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 1, 0, 1)));

  const std::string lines = "v 0 2 3 1 0 0\nvn 0 1 0\nv 4 5 6 0 0 1\n";
  const PointCloud obj =
      read_points(test::bytes_of(lines + "vn 1 0 0\n"), "a.obj", FileFormat::Obj);
  EXPECT_THAT(obj.normals, ElementsAre(glm::vec3(0, 1, 0), glm::vec3(1, 0, 0)));
  EXPECT_THAT(obj.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 0, 1, 1)));
  // One for two points could be either's.
  EXPECT_TRUE(read_points(test::bytes_of(lines), "a.obj", FileFormat::Obj).normals.empty());
}

TEST(PointCloud, NormalsAndColoursOfPcdComeAlong) {
  const std::string header =
      "FIELDS x y z normal_x normal_y normal_z curvature rgb\nSIZE 4 4 4 4 4 4 4 4\n"
      "TYPE F F F F F F F U\nCOUNT 1 1 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n";
  const PointCloud text = read_points(
      test::bytes_of(header + "DATA ascii\n1 2 3 0 1 0 9 16711680\nnan 5 6 1 0 0 9 255\n"), "a.pcd",
      FileFormat::Pcd);
  EXPECT_EQ(text.missing_count, 1);
  EXPECT_THAT(text.normals, ElementsAre(glm::vec3(0, 1, 0)));
  EXPECT_THAT(text.colors, ElementsAre(glm::vec4(1, 0, 0, 1)));

  std::string binary = header + "DATA binary\n";
  for (const double value : {1, 2, 3, 0, 1, 0, 9})
    test::append<float>(binary, static_cast<float>(value));
  test::append<std::uint32_t>(binary, 0xff00ff00);
  for (const double value : {4, 5, 6, 0, 0, 1, 9})
    test::append<float>(binary, static_cast<float>(value));
  test::append<std::uint32_t>(binary, 0x000000ff);
  const PointCloud bytes = read_points(test::bytes_of(binary), "a.pcd", FileFormat::Pcd);
  EXPECT_THAT(bytes.normals, ElementsAre(glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)));
  EXPECT_THAT(bytes.colors, ElementsAre(glm::vec4(0, 1, 0, 1), glm::vec4(0, 0, 1, 1)));
}

TEST(PointCloud, ReadsPrimitivesOfPointsWhereNothingElseIs) {
  using namespace test;
  const auto points_of = [](const std::string& primitive) {
    const std::string json =
        replaced(square_json(), "{\"attributes\":{\"POSITION\":0},\"indices\":1}", primitive);
    return read_mesh(
        bytes_of(glb_of(replaced(json, "{\"mesh\":0}", "{\"mesh\":0,\"translation\":[0,0,5]}"),
                        square_chunk())),
        "a.glb", FileFormat::Glb);
  };
  const MeshFile points = points_of("{\"attributes\":{\"POSITION\":0},\"mode\":0}");
  EXPECT_THAT(points.mesh.positions, ElementsAre(glm::dvec3(0, 0, 5), glm::dvec3(1, 0, 5),
                                                 glm::dvec3(1, 1, 5), glm::dvec3(0, 1, 5)));
  EXPECT_EQ(points.mesh.face_count(), 0);
  const MeshFile both = points_of(
      "{\"attributes\":{\"POSITION\":0},\"mode\":0},"
      "{\"attributes\":{\"POSITION\":0},\"indices\":1}");
  EXPECT_EQ(both.mesh.positions.size(), 4u);
  EXPECT_EQ(both.mesh.face_count(), 2);
  EXPECT_EQ(both.dropped_element_count, 1);
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
