#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "files/read_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/files/formats.h"
#include "planish/files/mesh_file.h"
#include "planish/files/readers.h"
#include "planish/mesh/polygon_mesh.h"
#include "support/calls.h"

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

using testing::HasSubstr;

PointCloud xyz_of(std::string_view text, FileFormat format = FileFormat::Xyz) {
  return format == FileFormat::Pts ? read_pts(test::file_of(text, "a.xyz"))
                                   : read_xyz(test::file_of(text, "a.xyz"));
}
std::string xyz_error(std::string_view text, FileFormat format = FileFormat::Xyz) {
  return test::message_of(ErrorCode::UnreadableInput, [&] { (void)xyz_of(text, format); });
}

TEST(ReadXyz, ReadsColumnsHoweverTheyAreSeparated) {
  const auto points =
      xyz_of("1 2 3\n 4\t5  6 255 0 0\r\n7,8,9\n10;11;12;0\n\n# rest\n//x\n").points;
  EXPECT_THAT(points, ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6), glm::dvec3(7, 8, 9),
                                  glm::dvec3(10, 11, 12)));
}

TEST(ReadXyz, ReadsNumbersToTheLastBit) {
  EXPECT_EQ(xyz_of("0.1 4.9e-324 -1e100\n").points[0], glm::dvec3(0.1, 4.9e-324, -1e100));
}

TEST(ReadXyz, PassesOverColumnNamesInTheFirstLineOnly) {
  EXPECT_EQ(xyz_of("X Y Z\n1 2 3\n").points.size(), 1u);
  EXPECT_THAT(xyz_error("1 2 3\nX Y Z\n"), HasSubstr("a.xyz:2: coordinate `X`"));
}

// Numbers behind a word are a point that is damaged.
TEST(ReadXyz, TakesWordsAloneForColumnNames) {
  for (const char* names : {"X Y Z\n", "x,y,z,r,g,b\n", "\"x\";\"y\";\"z\"\n", "points\n",
                            "Version 1.0\n", "//c\n# c\nnot a number\n"})
    EXPECT_EQ(xyz_of(std::string(names) + "1 2 3\n").points.size(), 1u) << names;
  for (const char* word : {"inf", "-inf", "Infinity", "INF", "1e999", "1.#INF", "x1"}) {
    const std::string line = std::string(word) + " 0 0\n";
    const std::string what =
        "coordinate `" + std::string(word) + "` is no finite number up to 1e150";
    EXPECT_EQ(xyz_error(line + "1 2 3\n"), "a.xyz:1: " + what);
    EXPECT_EQ(xyz_error(line), "a.xyz:1: " + what);
    EXPECT_EQ(xyz_error("# scan\n\n" + line), "a.xyz:3: " + what);
    EXPECT_EQ(xyz_error("1\n" + line, FileFormat::Pts), "a.xyz:2: " + what);
  }
  EXPECT_EQ(xyz_error("0 inf 0\n"), "a.xyz:1: coordinate `inf` is no finite number up to 1e150");
  EXPECT_EQ(xyz_error("inf\n", FileFormat::Pts), "a.xyz:1: point count `inf` is no integer from 0");
}

TEST(ReadXyz, CountsMissingPoints) {
  const PointCloud cloud = xyz_of("nan nan nan\n1 2 3\n1 NaN 3\n-nan(ind) 1 -1.#IND\n");
  EXPECT_EQ(cloud.points.size(), 1u);
  EXPECT_EQ(cloud.missing_count, 3);
}

TEST(ReadXyz, NamesLineAndValueOfErrors) {
  EXPECT_THAT(xyz_error("1 2 3\n1 2\n"), HasSubstr("a.xyz:2: a point needs 3"));
  EXPECT_THAT(xyz_error("1 2 inf\n"), HasSubstr("a.xyz:1: coordinate `inf`"));
  EXPECT_THAT(xyz_error("1 2 1e200\n"), HasSubstr("up to 1e150"));
}

TEST(ReadXyz, RefusesDecimalCommas) {
  for (const char* line : {"153,651 150,000 249,933", "1,5;2,5;3,5", "1\t2\t3,5", "1 2 3 0,5"}) {
    const std::string error = xyz_error("1 2 3\n" + std::string(line) + "\n");
    EXPECT_THAT(error, HasSubstr("a.xyz:2: `")) << line;
    EXPECT_THAT(error, HasSubstr("its comma separates no columns")) << line;
  }
  EXPECT_THAT(xyz_error("\"1,5\";\"2,5\";\"3,5\"\n"), HasSubstr("separates no columns"));
  EXPECT_THAT(xyz_error("\"1,5\",\"2,5\",\"3,5\"\n"), HasSubstr("write 1.5 if that is meant"));
  for (const char* line : {"1,2,3", "1, 2, 3", "1 ,2 ,3", "1;2;3", "1,2,3 4,5,6"})
    EXPECT_EQ(xyz_of(line).points[0], glm::dvec3(1, 2, 3)) << line;
}

TEST(ReadXyz, PassesOverWhatProgramsPutAround) {
  EXPECT_THAT(xyz_of("@File_Version: 4\n@Type: 3\n#End\n\"1\" \"2\" \"3\"\nEOD\n").points,
              ElementsAre(glm::dvec3(1, 2, 3)));
}

std::vector<std::string> attributes_of(const PointCloud& cloud) {
  std::vector<std::string> names;
  for (const VertexAttribute& attribute : cloud.attributes) names.push_back(attribute.name);
  return names;
}

TEST(ReadXyz, TakesColumnsByTheirNames) {
  for (const char* names :
       {"x y z nx ny nz r g b intensity Label\n", "//X Y Z Nx Ny Nz R G B Intensity Label\n",
        "# scan\n# x,y,z,normal_x,normal_y,normal_z,red,green,blue,i,label\n",
        "\"x\";\"y\";\"z\";\"NormalX\";\"NormalY\";\"NormalZ\";\"R\";\"G\";\"B\";\"I\";"
        "\"label\"\n"}) {
    const PointCloud cloud = xyz_of(std::string(names) + "1 2 3 0 0 2 255 0 51 0.5 7\n" +
                                    "nan 2 3 0 0 1 0 0 0 0 0\n4 5 6 1 0 0 0 255 0 -8 9\n");
    EXPECT_THAT(cloud.normals, ElementsAre(glm::vec3(0, 0, 2), glm::vec3(1, 0, 0))) << names;
    ASSERT_EQ(cloud.colors.size(), 2u) << names;
    EXPECT_NEAR(cloud.colors[0].b, 0.0331, 1e-4);  // of sRGB
    EXPECT_EQ(cloud.colors[1], glm::vec4(0, 1, 0, 1));
    EXPECT_THAT(attributes_of(cloud), ElementsAre("intensity", "label"));
    EXPECT_THAT(cloud.attributes[0].values, ElementsAre(0.5f, -8.0f));
    EXPECT_THAT(cloud.attributes[1].values, ElementsAre(7.0f, 9.0f));
    EXPECT_TRUE(cloud.warnings.empty()) << cloud.warnings[0].message;
  }
  EXPECT_EQ(xyz_of("x y z r g b\n1 2 3 0.5 1 0\n").colors[0].g, 1.0f);
  EXPECT_EQ(xyz_of("x y z r g b\n1 2 3 0 65535 0\n").colors[0].g, 1.0f);
  EXPECT_THAT(
      xyz_error("id x y z\n1 2 3 4\n"),
      HasSubstr("a.xyz:1: the columns are `id x y z`, of which x, y and z are wanted first"));
}

std::string only_warning(const PointCloud& cloud) {
  EXPECT_EQ(cloud.warnings.size(), 1u);
  if (cloud.warnings.empty()) return {};
  EXPECT_EQ(cloud.warnings[0].code, "columns");
  return cloud.warnings[0].message;
}

// What nobody names is taken where only one thing fits, and said.
TEST(ReadXyz, SaysWhatColumnsWithoutNamesAreTakenFor) {
  const PointCloud normals = xyz_of("1 2 3 0 0 -1\n4 5 6 0.6 0.8 0\n");
  EXPECT_THAT(normals.normals, ElementsAre(glm::vec3(0, 0, -1), glm::vec3(0.6f, 0.8f, 0)));
  EXPECT_EQ(only_warning(normals),
            "a.xyz: 3 columns behind x y z, which no first line names, are taken as nx ny nz by "
            "their number and values; a line `x y z` and a name for each before the points says "
            "otherwise");
  const PointCloud colors = xyz_of("1 2 3 255 0 0\n4 5 6 0 9 0\n");
  EXPECT_EQ(colors.colors.size(), 2u);
  EXPECT_THAT(only_warning(colors), HasSubstr("are taken as red green blue"));
  const PointCloud intensity = xyz_of("1 2 3 0.25\n");
  EXPECT_THAT(attributes_of(intensity), ElementsAre("intensity"));
  EXPECT_THAT(only_warning(intensity), HasSubstr("1 column behind x y z"));
  const PointCloud both = xyz_of("1 2 3 255 0 0 0 0 1\n4 5 6 0 9 0 0 1 0\n");
  EXPECT_EQ(both.colors.size(), 2u);
  EXPECT_EQ(both.normals.size(), 2u);
  EXPECT_THAT(only_warning(both), HasSubstr("red green blue nx ny nz"));
  const PointCloud all = xyz_of("1 2 3 0.6 0.8 0 9 9 255 -7\n4 5 6 0 1 0 9 9 25 0.5\n");
  EXPECT_THAT(only_warning(all), HasSubstr("nx ny nz red green blue intensity"));
}

TEST(ReadXyz, LeavesOutColumnsThatNobodyCanTellApart) {
  for (const char* text :
       {"1 2 3 7 7\n", "1 2 3 0.5 300 2\n", "1 2 3 0 0 1\n", "1 2 3 4 5 6 7\n"}) {
    const PointCloud cloud = xyz_of(text);
    EXPECT_TRUE(cloud.colors.empty() && cloud.normals.empty() && cloud.attributes.empty()) << text;
    EXPECT_THAT(only_warning(cloud), HasSubstr("are left out; a line `x y z`")) << text;
  }
}

TEST(ReadXyz, LeavesOutColumnsThatLackNumbers) {
  const PointCloud cloud = xyz_of("x y z a b c\n1 2 3 4 5 6\n1 2 4 4 tree 6\n1 2 5 4 5\n");
  EXPECT_THAT(attributes_of(cloud), ElementsAre("a"));
  EXPECT_EQ(only_warning(cloud),
            "a.xyz:3: column 5 holds `tree`, which is no number; columns that are not of every "
            "point are left out");
  EXPECT_THAT(only_warning(xyz_of("x y z a\n1 2 3 4\n1 2 4\n")),
              HasSubstr("a.xyz:3: a point has 3 columns, the first has more"));
  const PointCloud wrong = xyz_of("x y z r g b\n1 2 3 -1 0 0\n");
  EXPECT_TRUE(wrong.colors.empty());
  EXPECT_THAT(only_warning(wrong), HasSubstr("colours are left out"));
  const PointCloud uneven = xyz_of("x y z a b\n1 2 3 0.5\n");
  EXPECT_EQ(uneven.warnings.size(), 2u);
  EXPECT_THAT(uneven.warnings[0].message, HasSubstr("names of 5 columns"));
}

// Intensity, and colours behind it, are the format's own.
TEST(ReadPts, GivesIntensityAndColors) {
  const PointCloud cloud = xyz_of("2\n1 2 3 -1200 255 0 0\n4 5 6 8 0 0 255\n", FileFormat::Pts);
  EXPECT_THAT(attributes_of(cloud), ElementsAre("intensity"));
  EXPECT_THAT(cloud.attributes[0].values, ElementsAre(-1200.0f, 8.0f));
  EXPECT_THAT(cloud.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 0, 1, 1)));
  EXPECT_TRUE(cloud.warnings.empty());
  EXPECT_TRUE(xyz_of("1\n1 2 3 7\n", FileFormat::Pts).warnings.empty());
}

TEST(ReadPts, HoldsCountsAgainstPoints) {
  EXPECT_EQ(xyz_of("2\n1 2 3 0.5\n4 5 6 0.5\n1\n7 8 9\n", FileFormat::Pts).points.size(), 3u);
  EXPECT_EQ(xyz_of("1 2 3\n", FileFormat::Pts).points.size(), 1u);
  EXPECT_THAT(xyz_error("3\n1 2 3\n", FileFormat::Pts), HasSubstr("after 1 of 3 points"));
  EXPECT_THAT(xyz_error("3\n1 2 3\n1\n4 5 6\n", FileFormat::Pts),
              HasSubstr("a.xyz:3: a point count"));
  EXPECT_THAT(xyz_error("-3\n", FileFormat::Pts), HasSubstr("`-3`"));
}

TEST(ReadPts, TellsOfPointsThatNoCountPromises) {
  const PointCloud cloud = xyz_of("# scan\n2\n1 2 3\n4 5 6\n7 8 9\nnan 1 1\n", FileFormat::Pts);
  EXPECT_EQ(cloud.points.size(), 3u);
  ASSERT_EQ(cloud.warnings.size(), 1u);
  EXPECT_EQ(cloud.warnings[0].code, "point-count");
  EXPECT_EQ(cloud.warnings[0].message,
            "a.xyz:5: 2 points stand behind the 2 that line 2 counts; they are read as well");
  EXPECT_EQ(cloud.warnings[0].count, 2);
  EXPECT_EQ(cloud.warnings[0].first, 2);
  EXPECT_EQ(xyz_of("0\n1 2 3\n", FileFormat::Pts).warnings.size(), 1u);
  EXPECT_TRUE(xyz_of("1 2 3\n4 5 6\n", FileFormat::Pts).warnings.empty());
  EXPECT_TRUE(xyz_of("2\n1 2 3\n4 5 6\n", FileFormat::Pts).warnings.empty());
}

std::string expand(std::vector<int> data, std::size_t size) {
  std::vector<std::byte> bytes;
  for (const int value : data) bytes.push_back(static_cast<std::byte>(value));
  std::string text;
  for (const std::byte b : expand_lzf(bytes, size)) text += static_cast<char>(b);
  return text;
}

TEST(Lzf, ExpandsLiteralsAndCopies) {
  EXPECT_EQ(expand({2, 'a', 'b', 'c'}, 3), "abc");
  // Copy of length 3 (1 + 2), distance 3.
  EXPECT_EQ(expand({2, 'a', 'b', 'c', 1 << 5, 2}, 6), "abcabc");
  // An overlapping copy repeats: length 7 + 1 + 2, distance 1.
  EXPECT_EQ(expand({0, 'x', 7 << 5, 1, 0}, 11), "xxxxxxxxxxx");
}

TEST(Lzf, RefusesDamagedData) {
  EXPECT_EQ(expand({2, 'a', 'b'}, 3), "");                // literals missing
  EXPECT_EQ(expand({2, 'a', 'b', 'c'}, 2), "");           // too long
  EXPECT_EQ(expand({2, 'a', 'b', 'c'}, 4), "");           // too short
  EXPECT_EQ(expand({0, 'a', 1 << 5, 1}, 4), "");          // from before the beginning
  EXPECT_EQ(expand({0, 'a', 1 << 5}, 4), "");             // distance missing
  EXPECT_EQ(expand({0, 'a', 7 << 5, 9}, 4), "");          // distance missing after a length
  EXPECT_EQ(expand({0, 'a'}, std::size_t{1} << 62), "");  // nothing expands that far
}

TEST(Lzf, SurvivesRandomData) {
  std::mt19937 random(1);
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::byte> data(random() % 64);
    for (std::byte& b : data) b = static_cast<std::byte>(random() % (round % 2 ? 256 : 40));
    const std::size_t size = random() % 300;
    const auto result = expand_lzf(data, size);
    EXPECT_TRUE(result.empty() || result.size() == size);
  }
}

PointCloud pcd_of(const std::string& text) { return read_pcd(test::file_of(text, "a.pcd")); }
std::string pcd_error(const std::string& text) {
  return test::message_of(ErrorCode::UnreadableInput, [&] { (void)pcd_of(text); });
}

template <class Value>
void append(std::string& text, Value value) {
  const auto raw = std::bit_cast<std::array<char, sizeof(Value)>>(value);
  text.append(raw.data(), raw.size());
}

std::string pcd_header(const std::string& fields, int points, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\n" + fields + "WIDTH " + std::to_string(points) +
         "\nHEIGHT 1\nVIEWPOINT 5 5 5 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " +
         data + "\n";
}
const std::string kPcdXyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
const std::string kMixed = "FIELDS rgb z _ x y\nSIZE 4 8 1 4 2\nTYPE U F U F I\nCOUNT 1 1 3 1 1\n";

TEST(ReadPcd, ReadsText) {
  const PointCloud cloud =
      pcd_of(pcd_header(kPcdXyz, 3, "ascii") + "1 2 3\nnan nan nan\n0.1 -5 6e1\n");
  EXPECT_THAT(cloud.points, ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(0.1, -5, 60)));
  EXPECT_EQ(cloud.missing_count, 1);
}

TEST(ReadPcd, FindsAxesAmongOtherFields) {
  EXPECT_THAT(pcd_of(pcd_header(kMixed, 1, "ascii") + "77 3 9 9 9 1 2\n").points,
              ElementsAre(glm::dvec3(1, 2, 3)));
  std::string text = pcd_header(kMixed, 2, "binary");
  for (int i = 0; i < 2; ++i) {
    append(text, std::uint32_t{77});
    append(text, 0.1 + i);
    text.append("___");
    append(text, 1.5f);
    append(text, std::int16_t{-2});
  }
  EXPECT_THAT(pcd_of(text).points, ElementsAre(glm::dvec3(1.5, -2, 0.1), glm::dvec3(1.5, -2, 1.1)));
}

template <class Value>
void expect_signed(int size) {
  const std::string n = std::to_string(size);
  std::string text = pcd_header("FIELDS x y z label\nSIZE " + n + " " + n + " " + n + " " + n +
                                    "\nTYPE I I I I\nCOUNT 1 1 1 1\n",
                                1, "binary");
  for (const int value : {-1, 0, 7, -2}) append(text, static_cast<Value>(value));
  const PointCloud cloud = pcd_of(text);
  EXPECT_THAT(cloud.points, ElementsAre(glm::dvec3(-1, 0, 7))) << size;
  EXPECT_THAT(cloud.attributes.at(0).values, ElementsAre(-2.0f)) << size;
}

TEST(ReadPcd, ReadsSignedIntegersOfEverySize) {
  expect_signed<std::int8_t>(1);
  expect_signed<std::int16_t>(2);
  expect_signed<std::int32_t>(4);
  expect_signed<std::int64_t>(8);
}

const std::string kIntense =
    "FIELDS x y z intensity rgb _ ring intensity Ring no\nSIZE 4 4 4 4 4 1 2 4 4 4\n"
    "TYPE F F F F U U U F F F\nCOUNT 1 1 1 1 1 1 1 1 1 2\n";

// In all kinds of files; of equal names the first, and fields of several numbers none.
TEST(ReadPcd, FurtherFieldsAreAttributes) {
  std::string bytes, columns;
  const std::array<std::array<float, 5>, 2> points{{{1, 2, 3, 0.5f, 8}, {4, 5, 6, 7, 9}}};
  for (const auto& [x, y, z, intensity, ring] : points) {
    for (const float value : {x, y, z, intensity}) append(bytes, value);
    append(bytes, std::uint32_t{255});
    bytes += '_';
    append(bytes, static_cast<std::uint16_t>(ring));
    for (int i = 0; i < 4; ++i) append(bytes, -1.0f);
  }
  for (std::size_t k = 0; k < 4; ++k)
    for (const auto& point : points) append(columns, point[k]);
  for (int i = 0; i < 2; ++i) append(columns, std::uint32_t{255});
  columns += "__";
  for (const auto& point : points) append(columns, static_cast<std::uint16_t>(point[4]));
  for (int i = 0; i < 8; ++i) append(columns, -1.0f);
  std::string packed = pcd_header(kIntense, 2, "binary_compressed"), literals;
  for (std::size_t at = 0; at < columns.size(); at += 32) {
    const std::string piece = columns.substr(at, 32);
    literals += static_cast<char>(piece.size() - 1) + piece;
  }
  append(packed, static_cast<std::uint32_t>(literals.size()));
  append(packed, static_cast<std::uint32_t>(columns.size()));
  const std::string text = "1 2 3 0.5 255 9 8 -1 -1 -1 -1\n4 5 6 7 255 9 9 -1 -1 -1 -1\n";
  for (const std::string& file : {pcd_header(kIntense, 2, "ascii") + text,
                                  pcd_header(kIntense, 2, "binary") + bytes, packed + literals}) {
    const PointCloud cloud = pcd_of(file);
    EXPECT_THAT(cloud.points, ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6)));
    ASSERT_EQ(cloud.attributes.size(), 2u);
    EXPECT_EQ(cloud.attributes[0].name, "intensity");
    EXPECT_THAT(cloud.attributes[0].values, ElementsAre(0.5f, 7));
    EXPECT_EQ(cloud.attributes[1].name, "ring");
    EXPECT_THAT(cloud.attributes[1].values, ElementsAre(8, 9));
    ASSERT_EQ(cloud.warnings.size(), 1u);
    EXPECT_EQ(cloud.warnings[0].code, "left-out-properties");
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("`intensity` of the points is left out"));
  }
}

TEST(ReadPcd, FurtherFieldsThatAreNoNumbersAreZero) {
  const std::string fields = "FIELDS x y z i\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n";
  std::string bytes = pcd_header(fields, 2, "binary");
  for (const float value : {1.0f, 2.0f, 3.0f, std::nanf(""), 4.0f, 5.0f, 6.0f, 7.0f})
    append(bytes, value);
  for (const std::string& file : {pcd_header(fields, 2, "ascii") + "1 2 3 nan\n4 5 6 7\n", bytes}) {
    const PointCloud cloud = pcd_of(file);
    ASSERT_EQ(cloud.attributes.size(), 1u);
    EXPECT_THAT(cloud.attributes[0].values, ElementsAre(0, 7));
    ASSERT_EQ(cloud.warnings.size(), 1u);
    EXPECT_EQ(cloud.warnings[0].code, "missing-properties");
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("point 0: i is nan"));
  }
}

// The same two points by literals of LZF: fields one after another.
std::string compressed_file() {
  std::string data;
  for (const float value : {1.0f, 4.0f, 2.0f, 5.0f, 3.0f, 6.0f}) append(data, value);
  std::string text = pcd_header(kPcdXyz, 2, "binary_compressed");
  append(text, static_cast<std::uint32_t>(data.size() + 1));
  append(text, static_cast<std::uint32_t>(data.size()));
  return text + static_cast<char>(data.size() - 1) + data;
}

TEST(ReadPcd, ReadsCompressedFieldsOneAfterAnother) {
  EXPECT_THAT(pcd_of(compressed_file()).points,
              ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6)));
}

TEST(ReadPcd, NamesWhatIsWrong) {
  EXPECT_THAT(pcd_error("VERSION 0.7\n"), HasSubstr("before the line DATA"));
  EXPECT_THAT(pcd_error("solid cube\n"), HasSubstr("a.pcd:1: unknown keyword `solid`"));
  EXPECT_THAT(pcd_error("FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\nDATA ascii\n"),
              HasSubstr("no `z`"));
  EXPECT_THAT(pcd_error("FIELDS x y z\nSIZE 4 3 4\n"), HasSubstr("a.pcd:2: SIZE `3`"));
  EXPECT_THAT(pcd_error("FIELDS x y z\nSIZE 4 4\n"), HasSubstr("fewer values"));
  EXPECT_THAT(pcd_error(pcd_header(kPcdXyz, 2, "ascii") + "1 2 3\n"), HasSubstr("promises 2"));
  EXPECT_THAT(pcd_error(pcd_header(kPcdXyz, 2, "ascii") + "1 2 3\n# long enough\n"),
              HasSubstr("ends at point 1 of 2"));
  EXPECT_THAT(pcd_error(pcd_header(kPcdXyz, 1, "ascii") + "1 2 x5\n"), HasSubstr("`x5`"));
  EXPECT_THAT(pcd_error(pcd_header(kPcdXyz, 2, "binary") + "12 bytes ..."),
              HasSubstr("2 points of 12"));
  EXPECT_THAT(pcd_error(pcd_header(kPcdXyz, 2, "zip")), HasSubstr("`zip`"));
  EXPECT_THAT(pcd_error(pcd_header(kPcdXyz, 2, "binary_compressed") + "abc"),
              HasSubstr("ends inside"));
  std::string damaged = compressed_file();
  damaged[damaged.size() - 25] = '\x7f';
  EXPECT_THAT(pcd_error(damaged), HasSubstr("damaged"));
  EXPECT_THAT(pcd_error(kPcdXyz + "WIDTH 3\nHEIGHT 2\nPOINTS 5\nDATA ascii\n"),
              HasSubstr("WIDTH times HEIGHT, 6"));
}

// Whatever the bytes, it is points or an error, never a crash or a wild allocation.
TEST(ReadPcd, SurvivesMutations) {
  std::string binary = pcd_header(kMixed, 2, "binary");
  binary.append(2 * 21, '\x3f');
  const std::array<std::string, 3> seeds = {pcd_header(kPcdXyz, 1, "ascii") + "1 2 3\n", binary,
                                            compressed_file()};
  std::mt19937 random(7);
  for (int round = 0; round < 30000; ++round) {
    std::string text = seeds[round % 3];
    for (unsigned i = 0; i <= random() % 4; ++i)
      text[random() % text.size()] = static_cast<char>(random() % 256);
    if (random() % 4 == 0) text.resize(random() % text.size());
    try {
      (void)pcd_of(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::UnreadableInput);
    }
  }
}

}  // namespace
}  // namespace planish
