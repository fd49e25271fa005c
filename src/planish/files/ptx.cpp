#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/files/readers.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

// Based on: Leica Geosystems, "Leica PTX format" (Cyclone's help): columns, rows, the scanner's
// place and axes, a matrix for row vectors, then a line for each point.

constexpr std::int64_t kHeadLines = 10;
constexpr std::int64_t kMostPoints = std::numeric_limits<std::int32_t>::max();

// One of a file.
struct PtxScan {
  std::int64_t columns = 0, rows = 0;
  std::int64_t first_record = 0;  // of its points
  glm::dvec3 place{0.0};
  std::array<glm::dvec3, 4> matrix{};  // rows: what the axes become, and the translation

  [[nodiscard]] std::int64_t count() const { return columns * rows; }
};

// Exactly `numbers` of a line.
template <std::size_t n>
std::array<double, n> scan_numbers(const TextLines& lines, const std::string& what) {
  std::array<double, n> numbers{};
  Words words(lines.line());
  for (double& number : numbers) {
    const std::string_view word = words.next();
    if (!parse_number(word, number) || std::abs(number) > kMaxCoordinate)
      lines.fail(formatted("{} needs {} numbers up to 1e150{}", what, n,
                           word.empty() ? "" : ", " + quote(word) + " is none"));
  }
  if (const std::string_view word = words.next(); !word.empty())
    lines.fail(formatted("{} has {} numbers; {} is one too many", what, n, quote(word)));
  return numbers;
}

std::int64_t size_of(const TextLines& lines, const std::string& what) {
  Words words(lines.line());
  const std::string_view word = words.next();
  std::int64_t size = 0;
  if (!parse_integer(word, size) || size < 0 || size > kMostPoints || !words.next().empty())
    lines.fail(formatted("{} {} is no integer from 0 to 2147483647", what, quote(lines.line())));
  return size;
}

// The ten lines behind the current one.
PtxScan read_head(TextLines lines) {
  PtxScan scan;
  const auto next = [&](const std::string& what) {
    if (!lines.next_with_words())
      lines.fail_at(std::max<std::int64_t>(lines.number(), 1),
                    "the file ends in a scan's header, before its " + what);
  };
  next("columns");
  scan.columns = size_of(lines, "the number of columns");
  next("rows");
  scan.rows = size_of(lines, "the number of rows");
  if (scan.columns > 0 && scan.rows > kMostPoints / scan.columns)
    lines.fail(formatted("{} times {} points are more than 2^31 - 1", scan.columns, scan.rows));
  next("scanner's place");
  const auto place = scan_numbers<3>(lines, "the scanner's place");
  scan.place = {place[0], place[1], place[2]};
  for (int axis = 0; axis < 3; ++axis) {
    next("scanner's axes");
    (void)scan_numbers<3>(lines, "a scanner's axis");
  }
  for (glm::dvec3& row : scan.matrix) {
    next("matrix");
    const auto numbers = scan_numbers<4>(lines, "a row of the scan's matrix");
    const bool is_last = &row == &scan.matrix.back();
    if (numbers[3] != (is_last ? 1 : 0))
      lines.fail("a row of the scan's matrix ends with " + shortest(numbers[3]) +
                 "; the first three end with 0 and the fourth with 1");
    row = {numbers[0], numbers[1], numbers[2]};
  }
  return scan;
}

// Where scans begin is known once all before are counted.
std::vector<PtxScan> read_heads(const LineRecords& records) {
  std::vector<PtxScan> scans;
  std::int64_t record = 0, total = 0;
  do {
    const TextLines before = records.before(record);
    PtxScan scan = read_head(before);
    scan.first_record = record + kHeadLines;
    record = scan.first_record + scan.count();
    total += scan.count();
    if (total > kMostPoints) before.fail("with this scan there are more than 2^31 - 1 points");
    scans.push_back(scan);
    // Reading the points says that some are missing, and where.
  } while (record < records.count());
  return scans;
}

class PtxReader {
 public:
  PtxReader(const FileBytes& file, std::size_t part_bytes)
      : lines_(file), records_(file, lines_, part_bytes) {}

  PointCloud read() {
    bool all_colored = true, all_intense = true;
    cloud_.attributes.push_back(attribute_of_size("intensity", 1, 0));
    for (const PtxScan& scan : read_heads(records_)) {
      std::vector<Part> parts(records_.part_count());
      records_.for_parts(
          scan.first_record, scan.first_record + scan.count(), "point",
          [&](std::size_t part, TextLines& lines, std::int64_t begin, std::int64_t end) {
            for (std::int64_t i = begin; i < end && lines.next_with_words(); ++i)
              read_point(lines, scan, i - scan.first_record, parts[part]);
          });
      for (Part& part : parts) append(part, all_colored, all_intense);
    }
    if (!all_colored) cloud_.colors = {};
    if (!all_intense || cloud_.points.empty()) cloud_.attributes = {};
    return std::move(cloud_);
  }

 private:
  struct Part {
    PointCloud cloud;
    std::vector<float> intensity;
    bool is_colored = true, is_intense = true;
  };

  static void read_point(const TextLines& lines, const PtxScan& scan, std::int64_t index,
                         Part& part) {
    constexpr std::size_t kPlace = 3, kIntensity = 4, kColored = 7;
    std::array<double, kColored> numbers{};
    Words words(lines.line());
    std::size_t count = 0;
    bool is_missing = false;
    for (; count < kColored; ++count) {
      const std::string_view word = words.next();
      if (word.empty()) break;
      if (parse_number(word, numbers[count]) &&
          (count >= kPlace || std::abs(numbers[count]) <= kMaxCoordinate))
        continue;
      if (count >= kPlace || !is_nan_word(word))
        lines.fail(formatted("the {}{} is no finite number up to 1e150",
                             count < kPlace ? "coordinate " : "value ", quote(word)),
                   index);
      is_missing = true;
    }
    if ((count != kPlace && count != kIntensity && count != kColored) || !words.next().empty())
      lines.fail("a point has x, y, z and may have intensity, or intensity and red, green, blue",
                 index);
    const glm::dvec3 seen(numbers[0], numbers[1], numbers[2]);
    if (is_missing || seen == glm::dvec3(0.0)) {
      ++part.cloud.missing_count;
      return;
    }
    const glm::dvec3 place = seen.x * scan.matrix[0] + seen.y * scan.matrix[1] +
                             seen.z * scan.matrix[2] + scan.matrix[3];
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(place[axis]) <= kMaxCoordinate))
        lines.fail("the scan's matrix moves the point beyond 1e150", index);
    part.cloud.points.push_back(place);
    part.is_intense = part.is_intense && count > kPlace;
    if (part.is_intense) part.intensity.push_back(static_cast<float>(numbers[kPlace]));
    part.is_colored = part.is_colored && count == kColored;
    if (part.is_colored)
      part.cloud.colors.push_back(
          linear_of_srgb(glm::dvec4(numbers[4] / 255, numbers[5] / 255, numbers[6] / 255, 1.0)));
  }

  void append(Part& part, bool& all_colored, bool& all_intense) {
    const auto join = [](auto& to, const auto& values) {
      to.insert(to.end(), values.begin(), values.end());
    };
    join(cloud_.points, part.cloud.points);
    cloud_.missing_count += part.cloud.missing_count;
    all_colored = all_colored && part.is_colored;
    if (all_colored) join(cloud_.colors, part.cloud.colors);
    all_intense = all_intense && part.is_intense;
    if (all_intense) join(cloud_.attributes[0].values, part.intensity);
    part = {};
  }

  TextLines lines_;
  LineRecords records_;
  PointCloud cloud_;
};

}  // namespace

PointCloud read_ptx(const FileBytes& file, std::size_t part_bytes) {
  return PtxReader(file, part_bytes).read();
}

ScanContents ptx_contents(const FileBytes& file) {
  ScanContents contents{.version = "PTX", .software = {}, .coordinate_system = {}};
  const LineRecords records(file, TextLines(file), kTextPartBytes);
  for (const PtxScan& scan : read_heads(records))
    contents.scans.emplace_back(
        formatted("scan {}, {} x {} from ({}, {}, {})", contents.scans.size() + 1, scan.columns,
                  scan.rows, shortest(scan.place.x), shortest(scan.place.y),
                  shortest(scan.place.z)),
        scan.count());
  return contents;
}

}  // namespace planish
