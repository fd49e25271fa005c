// Parts of the file are read on all threads; what a count promises is settled when they are joined.
#include "planish/files/xyz/read_xyz.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/files/shared/first_failure.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/xyz/point_columns.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

enum class TextPoints { Xyz, Pts };

using Columns = std::array<std::string_view, 3>;

// `@File_Version: 4` and the like stand before the points of some programs, and EOD behind them.
bool is_comment(std::string_view word) {
  return word.starts_with('#') || word.starts_with("//") || word.starts_with('@');
}

// The first three columns, which are taken from the line; none of a line that says nothing.
Columns columns_of(std::string_view& line) {
  Columns columns;
  columns[0] = take_column(line);
  if (is_comment(columns[0])) return {};
  columns[1] = take_column(line);
  if (columns[0] == "EOD" && columns[1].empty()) return {};
  columns[2] = take_column(line);
  return columns;
}

bool is_count(const Columns& columns, TextPoints kind) {
  return kind == TextPoints::Pts && columns[1].empty();
}

// Words that name the columns; numbers behind a word are a point that is damaged.
bool is_heading(const Columns& columns) {
  const char c = columns[0].front();
  const bool is_word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  double ignored = 0;
  return is_word && !is_non_finite_word(columns[0]) &&
         !(parse_number(columns[1], ignored) && parse_number(columns[2], ignored));
}

// What the lines before the first point say, and how many columns that has. Some programs name them
// in the first line, which is passed over, some in a comment.
PointColumns find_columns(TextLines& lines, TextPoints kind) {
  PointColumns found;
  found.is_pts = kind == TextPoints::Pts;
  bool may_be_heading = true;
  for (TextLines behind = lines; behind.next();) {
    std::string_view rest = behind.line();
    const Columns columns = columns_of(rest);
    const bool is_heading_line =
        !columns[0].empty() && may_be_heading && !is_count(columns, kind) && is_heading(columns);
    if (is_heading_line) lines = behind;
    if (columns[0].empty() || is_heading_line) {
      const std::vector<std::string> names = column_names(behind.line());
      if (!names.empty()) found.names = names;
      if (!names.empty() && !(names[0] == "x" && names[1] == "y" && names[2] == "z"))
        behind.fail("the columns are " + quote(behind.line()) +
                    ", of which x, y and z are wanted first, in this order");
    }
    if (!columns[0].empty()) may_be_heading = false;
    if (columns[0].empty() || is_heading_line || is_count(columns, kind)) continue;
    while (found.further < kMaxPointColumns && !take_column(rest).empty()) ++found.further;
    break;
  }
  return found;
}

// What the lines of a part say.
struct PointPart {
  struct Count {
    std::int64_t points_before, promised, line;
  };
  std::vector<glm::dvec3> points;
  std::vector<float> further;  // numbers behind the places, as many of each point
  ColumnFaults faults;
  std::int64_t missing_count = 0;
  std::vector<Count> counts;
  std::int64_t last_line = 0;

  [[nodiscard]] std::int64_t point_count() const { return std::ssize(points) + missing_count; }
};

void read_further(const TextLines& lines, std::string_view rest, std::size_t count,
                  PointPart& part) {
  for (std::size_t c = 0; c < count; ++c) {
    const std::string_view word = take_column(rest);
    double number = 0;
    if (!parse_number(word, number)) part.faults.add(c, lines.number(), word);
    part.further.push_back(static_cast<float>(number));
  }
}

void read_point(const TextLines& lines, const Columns& columns, std::string_view rest,
                std::size_t further, PointPart& part) {
  const std::int64_t index = part.point_count();
  if (const std::string_view number = number_with_comma(lines.line()); !number.empty())
    lines.fail(quote(number) +
                   ": its comma separates no columns, as other signs do here; write decimal "
                   "points, as \"tr , . < FILE\" does",
               index);
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
    if (columns[axis].find(',') != std::string_view::npos)  // between quotes
      lines.fail("coordinate " + no_finite_number(columns[axis]), index);
    lines.fail("coordinate " + quote(columns[axis]) + " is no finite number up to 1e150", index);
  }
  if (missing) {
    ++part.missing_count;
  } else {
    part.points.push_back(point);
    read_further(lines, rest, further, part);
  }
}

void read_point_part(TextLines lines, TextPoints kind, std::size_t further, PointPart& part) {
  while (lines.next()) {
    std::string_view rest = lines.line();
    const Columns columns = columns_of(rest);
    if (columns[0].empty()) continue;
    if (!is_count(columns, kind)) {
      read_point(lines, columns, rest, further, part);
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
    std::string_view rest = lines.line();
    const Columns columns = columns_of(rest);
    if (!columns[0].empty() && !is_count(columns, kind) && point-- == 0) break;
  }
  return lines.number();
}

class TextPointReader {
 public:
  TextPointReader(const FileBytes& file, TextPoints kind, std::size_t part_bytes)
      : name_(file.name), lines_(file), kind_(kind) {
    expect_passes(file, 2);
    columns_ = find_columns(lines_, kind);
    settle_names();
    parts_ = numbered_parts(lines_, part_bytes);
  }

  PointCloud read() {
    std::vector<PointPart> read(parts_.size());
    FirstFailure failure;
    parallel_for(parts_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p)
        failure.watch(p, [&] { read_point_part(parts_[p], kind_, columns_.further, read[p]); });
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
    return formatted("{} of {} points", since_promise(point), promise_.promised);
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
         .message = formatted("{}:{}: {}{}{} that line {} counts; {} read as well", name_, line,
                              counted(excess_count_, "point"),
                              excess_count_ == 1 ? " stands behind the " : " stand behind the ",
                              excess_promise_.promised, excess_promise_.line,
                              excess_count_ == 1 ? "it is" : "they are"),
         .count = excess_count_,
         .first = first});
  }

  void join(std::vector<PointPart>& read) {
    cloud_.points = std::move(read.front().points);
    cloud_.missing_count = read.front().missing_count;
    cloud_.points.reserve(static_cast<std::size_t>(points_before_.back()));
    std::vector<float> further = std::move(read.front().further);
    ColumnFaults faults = std::move(read.front().faults);
    for (std::size_t p = 1; p < read.size(); ++p) {
      further.insert(further.end(), read[p].further.begin(), read[p].further.end());
      if (faults.columns == 0) faults = read[p].faults;
      faults.columns |= read[p].faults.columns;
      cloud_.points.insert(cloud_.points.end(), read[p].points.begin(), read[p].points.end());
      cloud_.missing_count += read[p].missing_count;
      read[p] = {};
    }
    add_columns(columns_, further, faults, name_, cloud_);
  }

  // Names are of as many columns as points have.
  void settle_names() {
    const std::size_t count = columns_.further + std::tuple_size_v<Columns>;
    if (columns_.names.empty() || columns_.names.size() == count) return;
    if (columns_.further > 0)
      cloud_.warnings.push_back(
          {.code = "columns",
           .message =
               formatted("{}: names of {} columns are no names, since the first point has {}",
                         name_, columns_.names.size(), count)});
    columns_.names.clear();
  }

  std::string name_;
  TextLines lines_;
  TextPoints kind_;
  std::vector<TextLines> parts_;
  PointColumns columns_;
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
