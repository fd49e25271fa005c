#include "planish/files/xyz/read_xyz.h"
#include "planish/files/formats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
