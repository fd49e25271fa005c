// Parts of the file are read on all threads; what a count promises is settled when they are joined.
#include "planish/files/xyz/read_xyz.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "planish/core/counted.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/files/shared/first_failure.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

enum class TextPoints { Xyz, Pts };

using Columns = std::array<std::string_view, 3>;

bool is_separator(char c) { return c == ' ' || c == '\t' || c == ',' || c == ';'; }

// The next column; empty at the end of the line.
std::string_view take_column(std::string_view& line) {
  while (!line.empty() && is_separator(line.front())) line.remove_prefix(1);
  std::size_t size = 0;
  while (size < line.size() && !is_separator(line[size])) ++size;
  const std::string_view column = line.substr(0, size);
  line.remove_prefix(size);
  return column;
}

// The first three columns; none of a line that says nothing.
Columns columns_of(std::string_view line) {
  Columns columns;
  columns[0] = take_column(line);
  if (columns[0].starts_with('#') || columns[0].starts_with("//")) return {};
  columns[1] = take_column(line);
  columns[2] = take_column(line);
  return columns;
}

bool is_count(const Columns& columns, TextPoints kind) {
  return kind == TextPoints::Pts && columns[1].empty();
}

// Words that name the columns; numbers behind a word are a point that is damaged.
bool is_heading(const Columns& columns) {
  const char c = columns[0].front();
  const bool is_word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '"';
  double ignored = 0;
  return is_word && !is_non_finite_word(columns[0]) &&
         !(parse_number(columns[1], ignored) && parse_number(columns[2], ignored));
}

// Some programs name the columns in the first line.
void skip_heading(TextLines& lines, TextPoints kind) {
  for (TextLines behind = lines; behind.next();) {
    const Columns columns = columns_of(behind.line());
    if (columns[0].empty()) continue;
    if (!is_count(columns, kind) && is_heading(columns)) lines = behind;
    return;
  }
}

// What the lines of a part say.
struct PointPart {
  struct Count {
    std::int64_t points_before, promised, line;
  };
  std::vector<glm::dvec3> points;
  std::int64_t missing_count = 0;
  std::vector<Count> counts;
  std::int64_t last_line = 0;

  [[nodiscard]] std::int64_t point_count() const { return std::ssize(points) + missing_count; }
};

void read_point(const TextLines& lines, const Columns& columns, PointPart& part) {
  const std::int64_t index = part.point_count();
  if (columns[2].empty()) lines.fail("a point needs 3 coordinates", index);
  glm::dvec3 point(0.0);
  bool missing = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (parse_number(columns[axis], point[axis])) {
      if (std::abs(point[axis]) <= kMaxCoordinate) continue;
    } else if (is_nan_word(columns[axis])) {
      missing = true;
      continue;
    }
    lines.fail("coordinate " + quote(columns[axis]) + " is no finite number up to 1e150", index);
  }
  if (missing) {
    ++part.missing_count;
  } else {
    part.points.push_back(point);
  }
}

void read_point_part(TextLines lines, TextPoints kind, PointPart& part) {
  while (lines.next()) {
    const Columns columns = columns_of(lines.line());
    if (columns[0].empty()) continue;
    if (!is_count(columns, kind)) {
      read_point(lines, columns, part);
      continue;
    }
    std::int64_t count = 0;
    if (!parse_integer(columns[0], count) || count < 0)
      lines.fail("point count " + quote(columns[0]) + " is no integer from 0");
    part.counts.push_back({part.point_count(), count, lines.number()});
  }
  lines.count();
  part.last_line = lines.number();
}

// The line of a point of a part.
std::int64_t line_of(TextLines lines, TextPoints kind, std::int64_t point) {
  while (lines.next()) {
    const Columns columns = columns_of(lines.line());
    if (!columns[0].empty() && !is_count(columns, kind) && point-- == 0) break;
  }
  return lines.number();
}

class TextPointReader {
 public:
  TextPointReader(const FileBytes& file, TextPoints kind, std::size_t part_bytes)
      : name_(file.name), lines_(file), kind_(kind) {
    expect_passes(file, 2);
    skip_heading(lines_, kind);
    parts_ = numbered_parts(lines_, part_bytes);
  }

  PointCloud read() {
    std::vector<PointPart> read(parts_.size());
    FirstFailure failure;
    parallel_for(parts_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p)
        failure.watch(p, [&] { read_point_part(parts_[p], kind_, read[p]); });
    });
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      for (const PointPart::Count& count : read[p].counts) take_count(count);
      if (p == failure.part()) failure.rethrow(points_before_.back());
      points_before_.push_back(points_before_.back() + read[p].point_count());
    }
    settle_promise(points_before_.back());
    if (promise_.promised > since_promise(points_before_.back()))
      lines_.fail_at(std::max<std::int64_t>(read.back().last_line, 1),
                     "the file ends after " + kept_of(points_before_.back()));
    join(read);
    if (excess_count_ > 0) warn_of_excess();
    return std::move(cloud_);
  }

 private:
  [[nodiscard]] std::int64_t since_promise(std::int64_t point) const {
    return point - promise_.points_before;
  }
  [[nodiscard]] std::string kept_of(std::int64_t point) const {
    return std::to_string(since_promise(point)) + " of " + std::to_string(promise_.promised) +
           " points";
  }

  // Of the next part.
  void take_count(PointPart::Count count) {
    count.points_before += points_before_.back();
    if (promise_.promised > since_promise(count.points_before))
      lines_.fail_at(count.line, "a point count stands after " + kept_of(count.points_before));
    settle_promise(count.points_before);
    promise_ = count;
  }

  // Points up to `point` that no count promises.
  void settle_promise(std::int64_t point) {
    const std::int64_t excess = since_promise(point) - promise_.promised;
    if (promise_.line == 0 || excess <= 0) return;
    if (excess_count_ == 0) excess_promise_ = promise_;
    excess_count_ += excess;
  }

  // All are there, so that nothing is lost.
  void warn_of_excess() {
    const std::int64_t first = excess_promise_.points_before + excess_promise_.promised;
    const auto behind = std::ranges::upper_bound(points_before_, first);
    const auto part = static_cast<std::size_t>(behind - points_before_.begin()) - 1;
    const std::int64_t line = line_of(parts_[part], kind_, first - points_before_[part]);
    cloud_.warnings.push_back(
        {.code = "point-count",
         .message = name_ + ":" + std::to_string(line) + ": " + counted(excess_count_, "point") +
                    (excess_count_ == 1 ? " stands behind the " : " stand behind the ") +
                    std::to_string(excess_promise_.promised) + " that line " +
                    std::to_string(excess_promise_.line) + " counts; " +
                    (excess_count_ == 1 ? "it is" : "they are") + " read as well",
         .count = excess_count_,
         .first = first});
  }

  void join(std::vector<PointPart>& read) {
    cloud_.points = std::move(read.front().points);
    cloud_.missing_count = read.front().missing_count;
    cloud_.points.reserve(static_cast<std::size_t>(points_before_.back()));
    for (std::size_t p = 1; p < read.size(); ++p) {
      cloud_.points.insert(cloud_.points.end(), read[p].points.begin(), read[p].points.end());
      cloud_.missing_count += read[p].missing_count;
      read[p].points = {};
    }
  }

  std::string name_;
  TextLines lines_;
  TextPoints kind_;
  std::vector<TextLines> parts_;
  PointCloud cloud_;
  std::vector<std::int64_t> points_before_{0};     // each part; one more at the end
  PointPart::Count promise_{}, excess_promise_{};  // the last count, and the one before the excess
  std::int64_t excess_count_ = 0;
};

}  // namespace

PointCloud read_xyz(const FileBytes& file, std::size_t part_bytes) {
  return TextPointReader(file, TextPoints::Xyz, part_bytes).read();
}

PointCloud read_pts(const FileBytes& file, std::size_t part_bytes) {
  return TextPointReader(file, TextPoints::Pts, part_bytes).read();
}

}  // namespace planish
