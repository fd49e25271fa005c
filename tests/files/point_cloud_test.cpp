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
using testing::HasSubstr;

std::vector<std::string> attributes_of(const PointCloud& cloud) {
  std::vector<std::string> names;
  for (const VertexAttribute& attribute : cloud.attributes) names.push_back(attribute.name);
  return names;
}

PointCloud points_in(std::string_view text, std::string_view name) {
  return read_points(test::file_of(text, name), format_of(name).value());
}

TEST(PointCloud, ReadsTheVerticesOfMeshFormats) {
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"a.obj", "v 0.1 2 3\nv 4 5 6 0.5 0.5 0.5\n"},
           {"a.off", "OFF\n2 0 0\n0.1 2 3\n4 5 6\n"},
           {"a.ply",
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
            "property double z\nproperty float nx\nend_header\n0.1 2 3 0\n4 5 6 1\n"}})
    EXPECT_THAT(points_in(text, name).points,
                ElementsAre(glm::dvec3(0.1, 2, 3), glm::dvec3(4, 5, 6)))
        << name;
}

TEST(PointCloud, NormalsColoursAndFurtherPropertiesComeAlong) {
  const PointCloud ply = points_in(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar quality\n"
      "end_header\n0 2 3 0 0 2 255 0 0 9\n4 5 6 nan 0 1 0 255 0 7\n",
      "a.ply");
  EXPECT_THAT(ply.normals, ElementsAre(glm::vec3(0, 0, 2), glm::vec3(0, 0, 1)));
  EXPECT_THAT(ply.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 1, 0, 1)));
  EXPECT_THAT(attributes_of(ply), ElementsAre("quality"));
  EXPECT_THAT(ply.attributes[0].values, ElementsAre(9, 7));

  const std::string lines = "v 0 2 3 1 0 0\nvn 0 1 0\nv 4 5 6 0 0 1\n";
  const PointCloud obj = points_in(lines + "vn 1 0 0\n", "a.obj");
  EXPECT_THAT(obj.normals, ElementsAre(glm::vec3(0, 1, 0), glm::vec3(1, 0, 0)));
  EXPECT_THAT(obj.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 0, 1, 1)));
  // One for two points could be either's.
  EXPECT_TRUE(points_in(lines, "a.obj").normals.empty());
}

TEST(PointCloud, NormalsAndColoursOfPcdComeAlong) {
  const std::string header =
      "FIELDS x y z normal_x normal_y normal_z curvature rgb\nSIZE 4 4 4 4 4 4 4 4\n"
      "TYPE F F F F F F F U\nCOUNT 1 1 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n";
  const PointCloud text =
      points_in(header + "DATA ascii\n0.1 -5 6e1 0 1 0 9 16711680\nnan 5 6 1 0 0 9 255\n", "a.pcd");
  EXPECT_THAT(text.points, ElementsAre(glm::dvec3(0.1, -5, 60)));
  EXPECT_EQ(text.missing_count, 1);
  EXPECT_THAT(text.normals, ElementsAre(glm::vec3(0, 1, 0)));
  EXPECT_THAT(text.colors, ElementsAre(glm::vec4(1, 0, 0, 1)));
  const PointCloud binary = points_in(
      header + "DATA binary\n" + test::values<float>({1, 2, 3, 0, 1, 0, 9}) +
          test::values<std::uint32_t>({0xff00ff00}) + test::values<float>({4, 5, 6, 0, 0, 1, 9}) +
          test::values<std::uint32_t>({0x000000ff}),
      "a.pcd");
  EXPECT_THAT(binary.normals, ElementsAre(glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)));
  EXPECT_THAT(binary.colors, ElementsAre(glm::vec4(0, 1, 0, 1), glm::vec4(0, 0, 1, 1)));
}

TEST(PointCloud, ReadsPrimitivesOfPointsWhereNothingElseIs) {
  const auto file_of = [](const std::string& primitives) {
    const std::string json = test::replaced(
        test::square_json(), R"({"attributes":{"POSITION":0},"indices":1})", primitives);
    return test::read_glb(
        test::glb_of(test::replaced(json, R"({"mesh":0})", R"({"mesh":0,"translation":[0,0,5]})"),
                     test::square_chunk()));
  };
  const std::string points = R"({"attributes":{"POSITION":0},"mode":0})";
  const MeshFile alone = file_of(points);
  EXPECT_THAT(alone.mesh.positions, ElementsAre(glm::dvec3(0, 0, 5), glm::dvec3(1, 0, 5),
                                                glm::dvec3(1, 1, 5), glm::dvec3(0, 1, 5)));
  EXPECT_EQ(alone.mesh.face_count(), 0);
  const MeshFile both = file_of(points + R"(,{"attributes":{"POSITION":0},"indices":1})");
  EXPECT_EQ(both.mesh.positions.size(), 4u);
  EXPECT_EQ(both.mesh.face_count(), 2);
  EXPECT_EQ(both.dropped_element_count, 1);
}

TEST(PointCloud, RefusesCoordinatesThatOverflowWhenSquared) {
  EXPECT_THAT(test::message_of(ErrorCode::UnreadableInput,
                               [] { (void)points_in("v 0 0 0\nv 0 1e160 0\n", "a.obj"); }),
              HasSubstr("a.obj: point 1 of 2: a coordinate is beyond 1e150"));
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

PointCloud xyz_of(std::string_view text) { return read_xyz(test::file_of(text, "a.xyz")); }
PointCloud pts_of(std::string_view text) { return read_pts(test::file_of(text, "a.pts")); }
TEST(ReadXyz, ReadsColumnsHoweverTheyAreSeparated) {
  const auto points =
      xyz_of("1 2 3\n 4\t5  6 255 0 0\r\n7,8,9\n10;11;12;0\n0.1 4.9e-324 -1e100\n\n# rest\n//x\n")
          .points;
  EXPECT_THAT(points, ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6), glm::dvec3(7, 8, 9),
                                  glm::dvec3(10, 11, 12), glm::dvec3(0.1, 4.9e-324, -1e100)));
}

// Numbers behind a word are a point that is damaged.
TEST(ReadXyz, TakesWordsAloneForColumnNames) {
  for (const char* names : {"X Y Z\n", "x,y,z,r,g,b\n", "\"x\";\"y\";\"z\"\n", "points\n",
                            "Version 1.0\n", "//c\n# c\nnot a number\n"})
    EXPECT_EQ(xyz_of(std::string(names) + "1 2 3\n").points.size(), 1u) << names;
  for (const std::string word : {"inf", "-inf", "Infinity", "INF", "1e999", "1.#INF", "x1"}) {
    const std::string line = word + " 0 0\n";
    const std::string what = ": coordinate `" + word + "` is no finite number up to 1e150";
    test::expect_refused(
        "a.xyz",
        {{line + "1 2 3\n", "1" + what}, {line, "1" + what}, {"# scan\n\n" + line, "3" + what}});
    test::expect_refused("a.pts", {{"1\n" + line, "2" + what}});
  }
}

TEST(ReadXyz, NamesLineAndValueOfErrors) {
  test::expect_refused(
      "a.xyz",
      {{"1 2 3\nX Y Z\n", HasSubstr("2: coordinate `X`")},
       {"0 inf 0\n", "1: coordinate `inf` is no finite number up to 1e150"},
       {"1 2 inf\n", HasSubstr("1: coordinate `inf`")},
       {"1 2 1e200\n", HasSubstr("up to 1e150")},
       {"1 2 3\n1 2\n", HasSubstr("2: a point needs 3")},
       {"id x y z\n1 2 3 4\n",
        HasSubstr("1: the columns are `id x y z`, of which x, y and z are wanted first")}});
}

TEST(ReadXyz, CountsMissingPoints) {
  const PointCloud cloud = xyz_of("nan nan nan\n1 2 3\n1 NaN 3\n-nan(ind) 1 -1.#IND\n");
  EXPECT_EQ(cloud.points.size(), 1u);
  EXPECT_EQ(cloud.missing_count, 3);
}

TEST(ReadXyz, RefusesDecimalCommas) {
  for (const char* line : {"153,651 150,000 249,933", "1,5;2,5;3,5", "1\t2\t3,5", "1 2 3 0,5"})
    test::expect_refused("a.xyz", {{"1 2 3\n" + std::string(line) + "\n",
                                    testing::AllOf(testing::StartsWith("2: `"),
                                                   HasSubstr("its comma separates no columns"))}});
  test::expect_refused("a.xyz",
                       {{"\"1,5\";\"2,5\";\"3,5\"\n", HasSubstr("separates no columns")},
                        {"\"1,5\",\"2,5\",\"3,5\"\n", HasSubstr("write 1.5 if that is meant")}});
  for (const char* line : {"1,2,3", "1, 2, 3", "1 ,2 ,3", "1;2;3", "1,2,3 4,5,6"})
    EXPECT_EQ(xyz_of(line).points[0], glm::dvec3(1, 2, 3)) << line;
}

TEST(ReadXyz, PassesOverWhatProgramsPutAround) {
  EXPECT_THAT(xyz_of("@File_Version: 4\n@Type: 3\n#End\n\"1\" \"2\" \"3\"\nEOD\n").points,
              ElementsAre(glm::dvec3(1, 2, 3)));
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
  struct Row {
    const char *text, *warning;
    std::size_t normals, colors, attributes;
  };
  for (const auto& [text, warning, normal_count, color_count, attribute_count] :
       {Row{"1 2 3 255 0 0\n4 5 6 0 9 0\n", "are taken as red green blue", 0, 2, 0},
        Row{"1 2 3 0.25\n", "1 column behind x y z", 0, 0, 1},
        Row{"1 2 3 255 0 0 0 0 1\n4 5 6 0 9 0 0 1 0\n", "red green blue nx ny nz", 2, 2, 0},
        Row{"1 2 3 0.6 0.8 0 9 9 255 -7\n4 5 6 0 1 0 9 9 25 0.5\n",
            "nx ny nz red green blue intensity", 2, 2, 1},
        // What nobody can tell apart.
        Row{"1 2 3 7 7\n", "are left out; a line `x y z`", 0, 0, 0},
        Row{"1 2 3 0.5 300 2\n", "are left out; a line `x y z`", 0, 0, 0},
        Row{"1 2 3 0 0 1\n", "are left out; a line `x y z`", 0, 0, 0},
        Row{"1 2 3 4 5 6 7\n", "are left out; a line `x y z`", 0, 0, 0}}) {
    SCOPED_TRACE(text);
    const PointCloud cloud = xyz_of(text);
    EXPECT_THAT(only_warning(cloud), HasSubstr(warning));
    EXPECT_EQ(cloud.normals.size(), normal_count);
    EXPECT_EQ(cloud.colors.size(), color_count);
    EXPECT_THAT(attributes_of(cloud), testing::SizeIs(attribute_count));
    EXPECT_THAT(attributes_of(cloud), testing::Each("intensity"));
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
  const PointCloud cloud = pts_of("2\n1 2 3 -1200 255 0 0\n4 5 6 8 0 0 255\n");
  EXPECT_THAT(attributes_of(cloud), ElementsAre("intensity"));
  EXPECT_THAT(cloud.attributes[0].values, ElementsAre(-1200.0f, 8.0f));
  EXPECT_THAT(cloud.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 0, 1, 1)));
  EXPECT_TRUE(cloud.warnings.empty());
  EXPECT_TRUE(pts_of("1\n1 2 3 7\n").warnings.empty());
}

TEST(ReadPts, HoldsCountsAgainstPoints) {
  EXPECT_EQ(pts_of("2\n1 2 3 0.5\n4 5 6 0.5\n1\n7 8 9\n").points.size(), 3u);
  EXPECT_EQ(pts_of("1 2 3\n").points.size(), 1u);
  test::expect_refused("a.pts", {{"3\n1 2 3\n", HasSubstr("after 1 of 3 points")},
                                 {"3\n1 2 3\n1\n4 5 6\n", HasSubstr("3: a point count")},
                                 {"-3\n", HasSubstr("`-3`")},
                                 {"inf\n", "1: point count `inf` is no integer from 0"}});
}

TEST(ReadPts, TellsOfPointsThatNoCountPromises) {
  const PointCloud cloud = pts_of("# scan\n2\n1 2 3\n4 5 6\n7 8 9\nnan 1 1\n");
  EXPECT_EQ(cloud.points.size(), 3u);
  EXPECT_THAT(test::codes_of(cloud.warnings), ElementsAre("point-count"));
  EXPECT_EQ(cloud.warnings[0].message,
            "a.pts:5: 2 points stand behind the 2 that line 2 counts; they are read as well");
  EXPECT_EQ(cloud.warnings[0].count, 2);
  EXPECT_EQ(cloud.warnings[0].first, 2);
  EXPECT_EQ(pts_of("0\n1 2 3\n").warnings.size(), 1u);
  EXPECT_TRUE(pts_of("1 2 3\n4 5 6\n").warnings.empty());
  EXPECT_TRUE(pts_of("2\n1 2 3\n4 5 6\n").warnings.empty());
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

using test::append;

PointCloud pcd_of(const std::string& text) { return read_pcd(test::file_of(text, "a.pcd")); }
std::string pcd_header(const std::string& fields, int points, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\n" + fields + "WIDTH " + std::to_string(points) +
         "\nHEIGHT 1\nVIEWPOINT 5 5 5 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " +
         data + "\n";
}
const std::string kPcdXyz = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
const std::string kMixed = "FIELDS rgb z _ x y\nSIZE 4 8 1 4 2\nTYPE U F U F I\nCOUNT 1 1 3 1 1\n";

TEST(ReadPcd, FindsAxesAmongOtherFields) {
  EXPECT_THAT(pcd_of(pcd_header(kMixed, 1, "ascii") + "77 3 9 9 9 1 2\n").points,
              ElementsAre(glm::dvec3(1, 2, 3)));
  std::string text = pcd_header(kMixed, 2, "binary");
  for (int i = 0; i < 2; ++i) {
    append<std::uint32_t>(text, 77);
    append<double>(text, 0.1 + i);
    text.append("___");
    append<float>(text, 1.5f);
    append<std::int16_t>(text, -2);
  }
  EXPECT_THAT(pcd_of(text).points, ElementsAre(glm::dvec3(1.5, -2, 0.1), glm::dvec3(1.5, -2, 1.1)));
}

template <class Value>
void expect_signed() {
  const std::string n = " " + std::to_string(sizeof(Value));
  const PointCloud cloud = pcd_of(
      pcd_header("FIELDS x y z label\nSIZE" + n + n + n + n + "\nTYPE I I I I\nCOUNT 1 1 1 1\n", 1,
                 "binary") +
      test::values<Value>({-1, 0, 7, -2}));
  EXPECT_THAT(cloud.points, ElementsAre(glm::dvec3(-1, 0, 7))) << n;
  EXPECT_THAT(cloud.attributes.at(0).values, ElementsAre(-2.0f)) << n;
}

TEST(ReadPcd, ReadsSignedIntegersOfEverySize) {
  expect_signed<std::int8_t>();
  expect_signed<std::int16_t>();
  expect_signed<std::int32_t>();
  expect_signed<std::int64_t>();
}

const std::string kIntense =
    "FIELDS x y z intensity rgb _ ring intensity Ring no\nSIZE 4 4 4 4 4 1 2 4 4 4\n"
    "TYPE F F F F U U U F F F\nCOUNT 1 1 1 1 1 1 1 1 1 2\n";

// In all kinds of files; of equal names the first, and fields of several numbers none.
TEST(ReadPcd, FurtherFieldsAreAttributes) {
  using test::values;
  const std::string rest = values<float>({-1, -1, -1, -1});
  const std::string rgb = values<std::uint32_t>({255});
  const std::string points = values<float>({1, 2, 3, 0.5}) + rgb + "_" +
                             values<std::uint16_t>({8}) + rest + values<float>({4, 5, 6, 7}) + rgb +
                             "_" + values<std::uint16_t>({9}) + rest;
  const std::string columns = values<float>({1, 4, 2, 5, 3, 6, 0.5, 7}) + rgb + rgb + "__" +
                              values<std::uint16_t>({8, 9}) + rest + rest;
  std::string packed = pcd_header(kIntense, 2, "binary_compressed"), literals;
  for (std::size_t at = 0; at < columns.size(); at += 32) {
    const std::string piece = columns.substr(at, 32);
    literals += static_cast<char>(piece.size() - 1) + piece;
  }
  append<std::uint32_t>(packed, static_cast<std::uint32_t>(literals.size()));
  append<std::uint32_t>(packed, static_cast<std::uint32_t>(columns.size()));
  const std::string text = "1 2 3 0.5 255 9 8 -1 -1 -1 -1\n4 5 6 7 255 9 9 -1 -1 -1 -1\n";
  for (const std::string& file : {pcd_header(kIntense, 2, "ascii") + text,
                                  pcd_header(kIntense, 2, "binary") + points, packed + literals}) {
    const PointCloud cloud = pcd_of(file);
    EXPECT_THAT(cloud.points, ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6)));
    ASSERT_THAT(attributes_of(cloud), ElementsAre("intensity", "ring"));
    EXPECT_THAT(cloud.attributes[0].values, ElementsAre(0.5f, 7));
    EXPECT_THAT(cloud.attributes[1].values, ElementsAre(8, 9));
    ASSERT_THAT(test::codes_of(cloud.warnings), ElementsAre("left-out-properties"));
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("`intensity` of the points is left out"));
  }
}

TEST(ReadPcd, FurtherFieldsThatAreNoNumbersAreZero) {
  const std::string fields = "FIELDS x y z i\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n";
  for (const std::string& file :
       {pcd_header(fields, 2, "ascii") + "1 2 3 nan\n4 5 6 7\n",
        pcd_header(fields, 2, "binary") + test::values<float>({1, 2, 3, NAN, 4, 5, 6, 7})}) {
    const PointCloud cloud = pcd_of(file);
    ASSERT_EQ(cloud.attributes.size(), 1u);
    EXPECT_THAT(cloud.attributes[0].values, ElementsAre(0, 7));
    ASSERT_THAT(test::codes_of(cloud.warnings), ElementsAre("missing-properties"));
    EXPECT_THAT(cloud.warnings[0].message, HasSubstr("point 0: i is nan"));
  }
}

// The same two points by literals of LZF: fields one after another.
std::string compressed_file() {
  const std::string data = test::values<float>({1, 4, 2, 5, 3, 6});
  std::string text = pcd_header(kPcdXyz, 2, "binary_compressed");
  append<std::uint32_t>(text, static_cast<std::uint32_t>(data.size() + 1));
  append<std::uint32_t>(text, static_cast<std::uint32_t>(data.size()));
  return text + static_cast<char>(data.size() - 1) + data;
}

TEST(ReadPcd, NamesWhatIsWrong) {
  std::string damaged = compressed_file();
  damaged[damaged.size() - 25] = '\x7f';
  test::expect_refused(
      "a.pcd", {{"VERSION 0.7\n", HasSubstr("before the line DATA")},
                {"solid cube\n", HasSubstr("1: unknown keyword `solid`")},
                {"FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\nDATA ascii\n", HasSubstr("no `z`")},
                {"FIELDS x y z\nSIZE 4 3 4\n", HasSubstr("2: SIZE `3`")},
                {"FIELDS x y z\nSIZE 4 4\n", HasSubstr("fewer values")},
                {pcd_header(kPcdXyz, 2, "ascii") + "1 2 3\n", HasSubstr("promises 2")},
                {pcd_header(kPcdXyz, 2, "ascii") + "1 2 3\n# long enough\n",
                 HasSubstr("ends at point 1 of 2")},
                {pcd_header(kPcdXyz, 1, "ascii") + "1 2 x5\n", HasSubstr("`x5`")},
                {pcd_header(kPcdXyz, 2, "binary") + "12 bytes ...", HasSubstr("2 points of 12")},
                {pcd_header(kPcdXyz, 2, "zip"), HasSubstr("`zip`")},
                {pcd_header(kPcdXyz, 2, "binary_compressed") + "abc", HasSubstr("ends inside")},
                {damaged, HasSubstr("damaged")},
                {kPcdXyz + "WIDTH 3\nHEIGHT 2\nPOINTS 5\nDATA ascii\n",
                 HasSubstr("WIDTH times HEIGHT, 6")}});
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
