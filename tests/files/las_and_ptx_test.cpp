#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "files/read_bytes.h"
#include "planish/core/parallel.h"
#include "planish/files/mesh_file.h"
#include "planish/files/readers.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

using test::append;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

struct LasPoint {
  std::array<std::int32_t, 3> steps{};
  int kind = 1, flags = 0;
  std::uint16_t source = 7;
  std::array<std::uint16_t, 3> color{};
};

// A record as the standard lays it out; `spare` bytes of the user's behind it.
std::string las_bytes_of(const LasPoint& point, int format, std::size_t spare) {
  std::string bytes;
  for (const std::int32_t step : point.steps) append<std::int32_t>(bytes, step);
  append<std::uint16_t>(bytes, 500);  // intensity
  bytes += '\x11';                    // returns
  if (format < 6) {
    bytes += static_cast<char>(point.kind | point.flags << 5);
    bytes += std::string(2, '\0');  // angle, user data
    append<std::uint16_t>(bytes, point.source);
    if (format != 0 && format != 2) append<double>(bytes, 1.5);  // time
  } else {
    bytes += static_cast<char>(point.flags);
    bytes += static_cast<char>(point.kind);
    bytes += std::string(3, '\0');
    append<std::uint16_t>(bytes, point.source);
    append<double>(bytes, 1.5);
  }
  constexpr std::array kSizes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  for (const int with_color : {2, 3, 5, 7, 8, 10})
    if (format == with_color)
      for (const std::uint16_t channel : point.color) append<std::uint16_t>(bytes, channel);
  bytes.resize(static_cast<std::size_t>(kSizes.at(static_cast<std::size_t>(format))) + spare, 'u');
  return bytes;
}

struct LasFile {
  int minor = 2, format = 3;
  std::size_t spare = 0;
  std::vector<std::string> records;  // variable length ones, whole
  std::vector<LasPoint> points;
  std::array<double, 3> scale{0.001, 0.001, 0.001}, offset{0, 0, 0};

  [[nodiscard]] std::string bytes() const {
    const std::size_t head = minor == 4 ? 375 : minor == 3 ? 235 : 227;
    std::string all_records;
    for (const std::string& record : records) all_records += record;
    std::string out = "LASF" + std::string(20, '\0');
    out += '\1';
    out += static_cast<char>(minor);
    out += std::string("a scanner") + std::string(23, '\0');
    out += std::string("its program") + std::string(21, '\0');
    append<std::uint32_t>(out, 0);  // day and year
    append<std::uint16_t>(out, static_cast<std::uint16_t>(head));
    append<std::uint32_t>(out, static_cast<std::uint32_t>(head + all_records.size()));
    append<std::uint32_t>(out, static_cast<std::uint32_t>(records.size()));
    out += static_cast<char>(format);
    append<std::uint16_t>(out, static_cast<std::uint16_t>(las_bytes_of({}, format, spare).size()));
    append<std::uint32_t>(out, minor == 4 ? 0 : static_cast<std::uint32_t>(points.size()));
    out.resize(131, '\0');
    for (const double value : scale) append<double>(out, value);
    for (const double value : offset) append<double>(out, value);
    out.resize(head, '\0');
    if (minor == 4) {
      std::string count;
      append<std::uint64_t>(count, points.size());
      out.replace(247, 8, count);
    }
    out += all_records;
    for (const LasPoint& point : points) out += las_bytes_of(point, format, spare);
    return out;
  }
};

std::string variable_record(const std::string& user, std::uint16_t id, const std::string& content) {
  std::string out(2, '\0');
  out += user;
  out.resize(18, '\0');
  append<std::uint16_t>(out, id);
  append<std::uint16_t>(out, static_cast<std::uint16_t>(content.size()));
  out.resize(54, '\0');
  return out + content;
}

PointCloud las_of(const std::string& bytes) { return read_las(test::file_of(bytes, "a.las")); }
std::string las_with(std::string bytes, std::size_t place, const std::string& what) {
  return bytes.replace(place, what.size(), what);
}

TEST(ReadLas, EveryVersionAndFormatGivesPlacesAndColours) {
  for (int minor = 0; minor <= 4; ++minor) {
    for (int format = 0; format <= 10; ++format) {
      for (const std::size_t spare : {0, 5}) {
        SCOPED_TRACE(minor * 100 + format);
        const LasFile file{.minor = minor,
                           .format = format,
                           .spare = spare,
                           .records = {},
                           .points = {{.steps = {1, -2, 2147483647}, .color = {65535, 0, 0}},
                                      {.steps = {0, 0, -2147483647}, .color = {0, 0, 65535}}},
                           .scale = {0.5, 2, 1},
                           .offset = {10, 0, -1}};
        const PointCloud cloud = las_of(file.bytes());
        EXPECT_THAT(cloud.points, ElementsAre(glm::dvec3(10.5, -4, 2147483646.0),
                                              glm::dvec3(10, 0, -2147483648.0)));
        EXPECT_TRUE(cloud.warnings.empty());
        ASSERT_EQ(cloud.attributes.size(), 1u);
        EXPECT_EQ(cloud.attributes[0].name, "intensity");
        EXPECT_THAT(cloud.attributes[0].values, ElementsAre(500, 500));
        const bool has_colors =
            format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
        if (has_colors) {
          EXPECT_THAT(cloud.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 0, 1, 1)));
        } else {
          EXPECT_TRUE(cloud.colors.empty());
        }
      }
    }
  }
}

TEST(ReadLas, FarPlacesKeepTheirMillimetres) {
  LasFile file{.offset = {500000, 5400000, 100}};
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i)
    file.points.push_back({.steps = {static_cast<std::int32_t>(random() % 5000),
                                     static_cast<std::int32_t>(random() % 5000),
                                     static_cast<std::int32_t>(random() % 5000)}});
  const std::string bytes = file.bytes();
  const PointCloud cloud = read_points(test::file_of(bytes, "a.las"), FileFormat::Las);
  EXPECT_GT(cloud.origin.x, 499000);
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    const glm::dvec3 place = cloud.origin + cloud.points[i];
    for (int axis = 0; axis < 3; ++axis) {
      // The nearest double of the decimal, up to the two roundings.
      const double steps = file.points[i].steps[axis];
      const double exact = steps / 1000 + file.offset[axis];
      EXPECT_NEAR(place[axis], exact, 1e-9);
      EXPECT_EQ(std::round((place[axis] - file.offset[axis]) * 1000), steps);
    }
  }
}

TEST(ReadLas, NoiseAndWithheldPointsAreLeftOutAndCounted) {
  for (const int format : {1, 6}) {
    const int withheld = 4;  // the third flag of both
    LasFile file{.format = format};
    for (const auto& [kind, flags] :
         std::vector<std::pair<int, int>>{{2, 0}, {7, 0}, {18, 0}, {2, withheld}, {2, 3}, {6, 0}})
      file.points.push_back({.kind = kind, .flags = flags});
    const PointCloud cloud = las_of(file.bytes());
    // Class 18 is noise from format 6 on, before it is reserved.
    EXPECT_EQ(cloud.points.size(), format == 6 ? 3u : 4u);
    EXPECT_THAT(test::codes_of(cloud.warnings), ElementsAre("noise-points"));
    EXPECT_EQ(cloud.warnings[0].count, format == 6 ? 3 : 2);
  }
}

// Scanners and converters write the least number where a pulse has no place.
TEST(ReadLas, PointsWithoutAPlaceAreLeftOutAndCounted) {
  constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::min();
  LasFile file{.format = 1};
  file.points = {{.steps = {1, 2, 3}},
                 {.steps = {kNone, 2, 3}},
                 {.steps = {1, kNone, 3}},
                 {.steps = {kNone + 1, 2, 3}},
                 {.steps = {1, 2, kNone}, .kind = 7}};
  const PointCloud cloud = las_of(file.bytes());
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_EQ(cloud.points[1].x, 0.001 * (kNone + 1.0));
  EXPECT_EQ(cloud.missing_count, 2);
  EXPECT_THAT(test::codes_of(cloud.warnings), ElementsAre("noise-points"));
  EXPECT_EQ(cloud.warnings[0].count, 1);
}

TEST(ReadLas, ColoursOfEightBitsAreToldByTheBrightest) {
  LasFile file{.points = {{.color = {255, 0, 0}}, {.color = {0, 0, 128}}}};
  EXPECT_EQ(las_of(file.bytes()).colors[0], glm::vec4(1, 0, 0, 1));
  file.points[1].color[2] = 0x8000;
  EXPECT_NEAR(las_of(file.bytes()).colors[1].z, 0.2140, 1e-3);  // sRGB of a half
  file.points = {{}, {}};
  EXPECT_TRUE(las_of(file.bytes()).colors.empty());
}

TEST(ReadLas, ManyPointsAreTheSameOnAnyNumberOfThreads) {
  LasFile file;
  for (int i = 0; i < 150'000; ++i)
    file.points.push_back({.steps = {i, i % 7, 0}, .kind = i % 5 == 0 ? 7 : 1});
  const PointCloud cloud = las_of(file.bytes());
  ASSERT_EQ(cloud.points.size(), 120'000u);
  std::size_t at = 0;
  for (int i = 0; i < 150'000; ++i) {
    if (i % 5 == 0) continue;
    ASSERT_EQ(cloud.points[at++].x, i * 0.001);
  }
}

TEST(ReadLas, ContentsNameClassesLinesAndCoordinateSystem) {
  std::string keys;
  for (const std::uint16_t number : {1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 32633})
    append<std::uint16_t>(keys, number);
  LasFile file{.records = {variable_record("other", 2112, "no"),
                           variable_record("LASF_Projection", 34735, keys),
                           variable_record("LASF_Projection", 34737, "UTM 33N|")},
               .points = {{.kind = 2}, {.kind = 2, .source = 9}, {.kind = 31}}};
  const std::string bytes = file.bytes();
  const ScanContents contents = las_contents(test::file_of(bytes, "a.las"));
  EXPECT_EQ(contents.coordinate_system, "EPSG:32633, UTM 33N");
  EXPECT_EQ(contents.software, "its program");
  EXPECT_EQ(contents.version, "LAS 1.2, point format 3, 34 bytes a point");
  EXPECT_THAT(contents.classes, ElementsAre(Pair("2 ground", 2), Pair("31", 1)));
  EXPECT_THAT(contents.scans, ElementsAre(Pair("source 7", 2), Pair("source 9", 1)));
  file.records.push_back(variable_record("LASF_Projection", 2112, "PROJCS[\"a\"]"));
  EXPECT_EQ(las_contents(test::file_of(file.bytes(), "a.las")).coordinate_system, "PROJCS[\"a\"]");
}

TEST(ReadLas, SaysWhatIsWrong) {
  const std::string good = LasFile{.points = {{}, {}}}.bytes();
  test::expect_refused(
      "a.las",
      {{good.substr(0, 100), HasSubstr("ends at byte 100, inside the header")},
       {las_with(good, 0, "LAZF"), HasSubstr("does not begin with LASF")},
       {las_with(good, 25, "\5"), HasSubstr("LAS version 1.5 is not read")},
       {las_with(good, 104, "\x83"), HasSubstr("\"pdal translate")},
       {las_with(good, 104, "\x0B"), HasSubstr("format 11 is not from 0 to 10")},
       {las_with(good, 105, "\x20"), HasSubstr("format 3 have 34 bytes, and 32 are promised")},
       {las_with(good, 107, "\3"),
        HasSubstr("promises 3 points of 34 bytes, but only 68 bytes follow")},
       {las_with(good, 107, "\xff\xff\xff\xff"), HasSubstr("promises 4294967295")},
       {las_with(good, 96, std::string("\1\0\0\0", 4)), HasSubstr("points begin at byte 1,")},
       {las_with(good, 94, "\1"), HasSubstr("the header's size, 1,")},
       {las_with(good, 138, std::string(1, '\x7f') + "\xf0"),
        HasSubstr("make no coordinates up to 1e150")},
       {las_with(good, 139, std::string(8, '\0')), HasSubstr("scale 0 and offset 0 of axis y")}});
}

TEST(ReadLas, DamagedRecordsBetweenAreWarnedOf) {
  LasFile file{.records = {variable_record("a", 1, "abc")}, .points = {{}, {}, {}}};
  const std::string bytes = las_with(file.bytes(), 227 + 20, "\xff\xff");
  const PointCloud cloud = las_of(bytes);
  EXPECT_EQ(cloud.points.size(), 3u);
  EXPECT_THAT(test::messages_of(cloud.warnings),
              ElementsAre(HasSubstr("record at byte 227 of 65535 bytes ends behind the room")));
  test::expect_refused("a.las", {{bytes, HasSubstr("record at byte 227")}}, true);
}

// Whatever the bytes, it is points or an error.
void expect_read_or_refused(PointCloud (*read)(const std::string&), const std::string& bytes) {
  try {
    for (const glm::dvec3& point : read(bytes).points)
      ASSERT_TRUE(std::abs(point.x) <= 1e150 && std::abs(point.y) <= 1e150 &&
                  std::abs(point.z) <= 1e150);
  } catch (const Error& error) {
    ASSERT_EQ(error.code(), ErrorCode::UnreadableInput);
  }
}

TEST(ReadLas, CutOrChangedAnywhereItIsReadOrRefused) {
  const std::string good = LasFile{.minor = 4,
                                   .format = 7,
                                   .records = {variable_record("LASF_Projection", 2112, "a")},
                                   .points = {{.kind = 2}, {.kind = 18}, {.color = {1, 2, 3}}}}
                               .bytes();
  for (std::size_t size = 0; size < good.size(); ++size)
    test::expect_refused("a.las", {{good.substr(0, size), testing::StartsWith(" ")}});
  std::mt19937 random(5);
  for (int round = 0; round < 20'000; ++round) {
    std::string bytes = good;
    for (unsigned i = 1 + random() % 4; i > 0; --i)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    expect_read_or_refused(
        [](const std::string& changed) {
          const PointCloud cloud = las_of(changed);
          (void)las_contents(test::file_of(changed, "a.las"));
          return cloud;
        },
        bytes);
  }
}

// Two scans; the second is turned by a right angle about z and moved.
const std::string kPtx =
    "2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    "1 2 3 0.5 255 0 0\n0 0 0 0.5 0 0 0\n4 5 6 0.25 0 255 0\n-1 0 0 1 0 0 255\n"
    "1\n2\n10 20 30\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 20 30 1\n"
    "1 2 3 0 255 255 255\n0 0 1 0 0 0 0\n";

PointCloud ptx_of(const std::string& text) { return read_ptx(test::file_of(text, "a.ptx")); }
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

TEST(ReadPtx, IntensityAndColoursComeAlongWhereAllPointsHaveThem) {
  const PointCloud cloud = ptx_of(kPtx);
  ASSERT_EQ(cloud.attributes.size(), 1u);
  EXPECT_EQ(cloud.attributes[0].name, "intensity");
  EXPECT_THAT(cloud.attributes[0].values, ElementsAre(0.5f, 0.25f, 1, 0, 0));
  EXPECT_TRUE(ptx_of(test::replaced(kPtx, "4 5 6 0.25 0 255 0", "4 5 6")).attributes.empty());
  const PointCloud some = ptx_of(test::replaced(kPtx, "4 5 6 0.25 0 255 0", "4 5 6 0.25"));
  EXPECT_EQ(some.points.size(), 5u);
  EXPECT_TRUE(some.colors.empty());
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
  const auto with = [](const std::string& what, const std::string& by) {
    return test::replaced(kPtx, what, by);
  };
  test::expect_refused(
      "a.ptx",
      {{"", HasSubstr("ends in a scan's header, before its columns")},
       {"-1\n2\n", HasSubstr("1: the number of columns `-1` is no integer")},
       {"2\ntwo\n", HasSubstr("2: the number of rows `two`")},
       {"100000\n100000\n", HasSubstr("100000 times 100000 points are more")},
       {with("0 0 1\n", "0 0\n"), HasSubstr("6: a scanner's axis needs 3 numbers")},
       {with("0 0 0 1\n", "0 0 0 2\n"), HasSubstr("10: a row of the scan's matrix ends with 2")},
       {with("4 5 6 0.25 0 255 0", "4 5 six 0.25"), HasSubstr("13: the coordinate `six`")},
       {with("4 5 6 0.25 0 255 0", "4 5 6 0.25 9"), HasSubstr("13: a point has x, y, z")},
       {with("0 0 1 0 0 0 0\n", ""), HasSubstr("the file ends at point 1 of 2")},
       {kPtx + "7\n", HasSubstr("ends in a scan's header, before its rows")},
       {test::replaced(with("10 20 30 1\n", "1e150 0 0 1\n"), "0 1 0 0\n-1", "1e150 0 0 0\n-1"),
        HasSubstr("25: the scan's matrix moves the point beyond 1e150")}});
}

TEST(ReadPtx, CutOrChangedAnywhereItIsReadOrRefused) {
  // Up to the last point of the first scan, with which that is a file of its own.
  for (std::size_t size = 0; size < kPtx.find("-1 0 0 1"); ++size)
    test::expect_refused("a.ptx", {{kPtx.substr(0, size), testing::_}});
  std::mt19937 random(5);
  for (int round = 0; round < 20'000; ++round) {
    std::string text = kPtx;
    for (unsigned i = 1 + random() % 4; i > 0; --i)
      text[random() % text.size()] =
          random() % 4 == 0 ? static_cast<char>(random()) : "0123456789-+.e \n"[random() % 16];
    expect_read_or_refused(ptx_of, text);
  }
}

}  // namespace
}  // namespace planish
