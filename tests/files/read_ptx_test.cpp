#include "planish/files/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "files/file_of.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

// Two scans; the second is turned by a right angle about z and moved.
const std::string kPtx =
    "2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    "1 2 3 0.5 255 0 0\n0 0 0 0.5 0 0 0\n4 5 6 0.25 0 255 0\n-1 0 0 1 0 0 255\n"
    "1\n2\n10 20 30\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n"
    "1 2 3 0 255 255 255\n0 0 1 0 0 0 0\n";

PointCloud ptx_of(const std::string& text) { return read_ptx(test::file_of(text, "a.ptx")); }
std::string ptx_error(const std::string& text) {
  return test::message_of(ErrorCode::UnreadableInput, [&] { (void)ptx_of(text); });
}
std::string ptx_with(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST(ReadPtx, PlacesEachScanByItsMatrix) {
  const PointCloud cloud = ptx_of(kPtx);
  // Row vectors: x becomes the first row, y the second.
  EXPECT_THAT(cloud.points,
              ElementsAre(glm::dvec3(1, 2, 3), glm::dvec3(4, 5, 6), glm::dvec3(-1, 0, 0),
                          glm::dvec3(8, 21, 33), glm::dvec3(10, 20, 31)));
  EXPECT_EQ(cloud.missing_count, 1);
  EXPECT_THAT(cloud.colors,
              ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 1, 0, 1), glm::vec4(0, 0, 1, 1),
                          glm::vec4(1, 1, 1, 1), glm::vec4(0, 0, 0, 1)));
}

TEST(ReadPtx, IntensityComesAlongWhereAllPointsHaveIt) {
  const PointCloud cloud = ptx_of(kPtx);
  ASSERT_EQ(cloud.attributes.size(), 1u);
  EXPECT_EQ(cloud.attributes[0].name, "intensity");
  EXPECT_THAT(cloud.attributes[0].values, ElementsAre(0.5f, 0.25f, 1, 0, 0));
  EXPECT_TRUE(ptx_of(ptx_with(kPtx, "4 5 6 0.25 0 255 0", "4 5 6")).attributes.empty());
}

TEST(ReadPtx, ColoursOfSomePointsAreNone) {
  const PointCloud cloud = ptx_of(ptx_with(kPtx, "4 5 6 0.25 0 255 0", "4 5 6 0.25"));
  EXPECT_EQ(cloud.points.size(), 5u);
  EXPECT_TRUE(cloud.colors.empty());
}

TEST(ReadPtx, IsTheSameWhereverItIsCut) {
  const PointCloud whole = ptx_of(kPtx);
  for (std::size_t part = 1; part < 80; ++part) {
    const PointCloud cloud = read_ptx(test::file_of(kPtx, "a.ptx"), part);
    EXPECT_EQ(cloud.points, whole.points) << part;
    EXPECT_EQ(cloud.colors, whole.colors) << part;
    EXPECT_EQ(cloud.missing_count, 1);
  }
}

TEST(ReadPtx, ContentsNameTheScans) {
  EXPECT_THAT(ptx_contents(test::file_of(kPtx, "a.ptx")).scans,
              ElementsAre(Pair("scan 1, 2 x 2 from (0, 0, 0)", 4),
                          Pair("scan 2, 1 x 2 from (10, 20, 30)", 2)));
}

TEST(ReadPtx, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(ptx_error(""), HasSubstr("ends in a scan's header, before its columns"));
  EXPECT_THAT(ptx_error("-1\n2\n"), HasSubstr("a.ptx:1: the number of columns `-1` is no integer"));
  EXPECT_THAT(ptx_error("2\ntwo\n"), HasSubstr("a.ptx:2: the number of rows `two`"));
  EXPECT_THAT(ptx_error("100000\n100000\n"), HasSubstr("100000 times 100000 points are more"));
  EXPECT_THAT(ptx_error(ptx_with(kPtx, "0 0 1\n", "0 0\n")),
              HasSubstr("a.ptx:6: a scanner's axis needs 3 numbers"));
  EXPECT_THAT(ptx_error(ptx_with(kPtx, "0 0 0 1\n", "0 0 0 2\n")),
              HasSubstr("a.ptx:10: a row of the scan's matrix ends with 2"));
  EXPECT_THAT(ptx_error(ptx_with(kPtx, "4 5 6 0.25 0 255 0", "4 5 six 0.25")),
              HasSubstr("a.ptx:13: the coordinate `six`"));
  EXPECT_THAT(ptx_error(ptx_with(kPtx, "4 5 6 0.25 0 255 0", "4 5 6 0.25 9")),
              HasSubstr("a.ptx:13: a point has x, y, z"));
  EXPECT_THAT(ptx_error(ptx_with(kPtx, "0 0 1 0 0 0 0\n", "")),
              HasSubstr("the file ends at point 1 of 2"));
  EXPECT_THAT(ptx_error(kPtx + "7\n"), HasSubstr("ends in a scan's header, before its rows"));
  EXPECT_THAT(ptx_error(ptx_with(ptx_with(kPtx, "10 20 30 1\n", "1e150 0 0 1\n"), "0 1 0 0\n-1",
                                 "1e150 0 0 0\n-1")),
              HasSubstr("a.ptx:25: the scan's matrix moves the point beyond 1e150"));
}

TEST(ReadPtx, CutOrChangedAnywhereItIsReadOrRefused) {
  // Up to the last point of the first scan, with which that is a file of its own.
  for (std::size_t size = 0; size < kPtx.find("-1 0 0 1"); ++size)
    EXPECT_THAT(ptx_error(kPtx.substr(0, size)), HasSubstr("a.ptx")) << size;
  std::mt19937 random(5);
  for (int round = 0; round < 20'000; ++round) {
    std::string text = kPtx;
    for (unsigned i = 1 + random() % 4; i > 0; --i)
      text[random() % text.size()] =
          random() % 4 == 0 ? static_cast<char>(random()) : "0123456789-+.e \n"[random() % 16];
    try {
      for (const glm::dvec3& point : ptx_of(text).points)
        ASSERT_TRUE(std::abs(point.x) <= 1e150 && std::abs(point.y) <= 1e150 &&
                    std::abs(point.z) <= 1e150);
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ErrorCode::UnreadableInput);
    }
  }
}

}  // namespace
}  // namespace planish
