#include "planish/files/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "files/file_of.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

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
