#include "planish/files/formats.h"
#include "planish/files/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "files/file_of.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::ElementsAre;
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

}  // namespace
}  // namespace planish
