#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"
#include "planish/files/readers.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

constexpr std::size_t kPlace = 3;  // columns of x, y, z
constexpr std::size_t kNoColumn = kMaxPointColumns;

bool is_separator(char c) { return c == ' ' || c == '\t' || c == ',' || c == ';'; }

// What programs call one thing.
std::string known_name(const std::string& name) {
  static const std::map<std::string, std::string, std::less<>> names = {
      {"r", "red"},       {"g", "green"},     {"b", "blue"},      {"i", "intensity"},
      {"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}, {"normalx", "nx"},
      {"normaly", "ny"},  {"normalz", "nz"}};
  const auto known = names.find(name);
  return known == names.end() ? name : known->second;
}

using Triple = std::array<std::size_t, 3>;  // columns

class ColumnValues {
 public:
  ColumnValues(std::span<const float> values, std::size_t width)
      : values_(values), width_(width), count_(values.size() / width) {}

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] float operator()(std::size_t point, std::size_t column) const {
    return values_[point * width_ + column];
  }
  // Values of colours from 0 to what this says: 1, 255 or 65535; nothing: they are none.
  [[nodiscard]] std::optional<float> color_scale(const Triple& columns) const {
    float most = 0;
    bool is_whole = true;
    for (std::size_t i = 0; i < count_; ++i) {
      for (const std::size_t column : columns) {
        const float value = (*this)(i, column);
        if (!(value >= 0)) return std::nullopt;
        most = std::max(most, value);
        is_whole = is_whole && value == std::floor(value);
      }
    }
    if (!is_whole) return most <= 1 ? std::optional(1.0f) : std::nullopt;
    if (most <= 255) return 255.0f;
    return most <= 65535 ? std::optional(65535.0f) : std::nullopt;
  }
  [[nodiscard]] bool are_bytes(const Triple& columns) const { return color_scale(columns) == 255; }
  [[nodiscard]] bool are_unit(const Triple& columns) const {
    constexpr double kRounding = 0.02;  // of files with two digits
    bool any = false;
    for (std::size_t i = 0; i < count_; ++i) {
      double square = 0;
      for (const std::size_t column : columns) {
        const double value = (*this)(i, column);
        square += value * value;
      }
      if (square == 0) continue;
      if (std::abs(std::sqrt(square) - 1) > kRounding) return false;
      any = true;
    }
    return any;
  }

 private:
  std::span<const float> values_;
  std::size_t width_, count_;
};

// Names that the values allow, where nobody gives any; empty: none, or several.
std::vector<std::string> names_by_values(const PointColumns& columns, const ColumnValues& values) {
  constexpr std::array kOrders = {"i",  "n",   "c",   "ic",  "ci",  "in",  "ni", "cn",
                                  "nc", "icn", "inc", "cin", "cni", "nic", "nci"};
  std::vector<std::string> found;
  for (const std::string_view order : kOrders) {
    std::vector<std::string> names;
    bool fits = true;
    for (const char kind : order) {
      const std::size_t at = names.size();
      if (kind == 'i') {
        names.emplace_back("intensity");
        continue;
      }
      for (const char* name :
           kind == 'n' ? std::array{"nx", "ny", "nz"} : std::array{"red", "green", "blue"})
        names.emplace_back(name);
      if (names.size() > columns.further) break;
      const Triple triple{at, at + 1, at + 2};
      fits = fits && (kind == 'n' ? values.are_unit(triple) : values.are_bytes(triple));
    }
    if (!fits || names.size() != columns.further) continue;
    if (!found.empty()) return {};
    found = std::move(names);
    if (columns.is_pts && (order == "i" || order == "ic")) break;
  }
  return found;
}

std::string names_as_text(std::span<const std::string> names) {
  std::string text;
  for (const std::string& name : names) {
    if (!text.empty()) text += ' ';
    text += name;
  }
  return text;
}

// Columns of a name each; kNoColumn: there is none, or it lacks numbers.
Triple columns_of_names(std::span<const std::string> names, const ColumnFaults& faults,
                        const std::array<const char*, 3>& wanted) {
  Triple columns{};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto found =
        static_cast<std::size_t>(std::ranges::find(names, wanted[k]) - names.begin());
    const bool has = found < names.size() && (faults.columns >> found & 1) == 0;
    columns[k] = has ? found : kNoColumn;
  }
  return columns;
}

bool has_all(const Triple& columns) {
  return std::ranges::find(columns, kNoColumn) == columns.end();
}

void add_colors(const Triple& columns, float scale, const ColumnValues& values, PointCloud& cloud) {
  for (std::size_t i = 0; i < values.count(); ++i) {
    glm::dvec4 color(0, 0, 0, 1);
    for (int k = 0; k < 3; ++k) color[k] = static_cast<double>(values(i, columns[k]) / scale);
    cloud.colors.push_back(linear_of_srgb(color));
  }
}

}  // namespace

void ColumnFaults::add(std::size_t column, std::int64_t at_line, std::string_view found) {
  columns |= std::uint64_t{1} << column;
  if (line != 0) return;
  line = at_line;
  what =
      found.empty()
          ? "a point has " + counted(static_cast<std::int64_t>(column + kPlace), "column") +
                ", the first has more"
          : formatted("column {} holds {}, which is no number", column + kPlace + 1, quote(found));
}

void add_columns(const PointColumns& columns, std::span<const float> values,
                 const ColumnFaults& faults, std::string_view file, PointCloud& cloud) {
  if (columns.further == 0 || values.empty()) return;
  const auto warn = [&](const std::string& what) {
    cloud.warnings.push_back({.code = "columns", .message = std::string(file) + what});
  };
  if (faults.columns != 0)
    warn(formatted(":{}: {}; columns that are not of every point are left out", faults.line,
                   faults.what));
  const ColumnValues of(values, columns.further);
  std::vector<std::string> names;
  if (!columns.names.empty()) {
    for (const std::string& name : std::span(columns.names).subspan(kPlace))
      names.push_back(known_name(name));
  } else {
    if (faults.columns == 0) names = names_by_values(columns, of);
    const bool is_formats = columns.is_pts && !names.empty() && names[0] == "intensity";
    const std::string all = counted(static_cast<std::int64_t>(columns.further), "column") +
                            " behind x y z, which no first line names, ";
    const bool is_one = columns.further == 1;
    if (names.empty())
      warn(
          formatted(": {}{} left out; a line `x y z` and a name for each before the points says "
                    "what they are",
                    all, is_one ? "is" : "are"));
    else if (!is_formats)
      warn(
          formatted(": {}{} taken as {} by {} number and values; a line `x y z` and a name for "
                    "each before the points says otherwise",
                    all, is_one ? "is" : "are", names_as_text(names), is_one ? "its" : "their"));
  }
  if (names.empty()) return;
  std::vector<bool> is_taken(names.size(), false);
  const auto take = [&](const Triple& triple) {
    for (const std::size_t column : triple) is_taken[column] = true;
  };
  if (const Triple normal = columns_of_names(names, faults, {"nx", "ny", "nz"}); has_all(normal)) {
    for (std::size_t i = 0; i < of.count(); ++i)
      cloud.normals.emplace_back(of(i, normal[0]), of(i, normal[1]), of(i, normal[2]));
    take(normal);
  }
  const Triple color = columns_of_names(names, faults, {"red", "green", "blue"});
  if (has_all(color)) {
    if (const auto scale = of.color_scale(color)) {
      add_colors(color, *scale, of, cloud);
    } else {
      warn(
          ": colours are left out; they are numbers from 0 to 1, or whole ones from 0 to 255 or "
          "65535");
    }
    take(color);
  }
  PropertyNames properties;
  for (std::size_t c = 0; c < names.size(); ++c) {
    if (is_taken[c] || (faults.columns >> c & 1) != 0 || !properties.add(names[c])) continue;
    VertexAttribute& attribute =
        cloud.attributes.emplace_back(attribute_of_size(properties.names().back(), 1, of.count()));
    for (std::size_t i = 0; i < of.count(); ++i) attribute.values[i] = of(i, c);
  }
  properties.warn(cloud.warnings, file, "points");
}

std::vector<std::string> column_names(std::string_view line) {
  while (line.starts_with('#') || line.starts_with('/')) line.remove_prefix(1);
  std::vector<std::string> names;
  for (std::string_view word = take_column(line); !word.empty(); word = take_column(line))
    names.push_back(lower_case(word));
  for (const char* axis : {"x", "y", "z"})
    if (std::ranges::count(names, axis) != 1) return {};
  return names;
}

std::string_view take_column(std::string_view& line) {
  while (!line.empty() && is_separator(line.front())) line.remove_prefix(1);
  if (const std::size_t end = line.find('"', 1); line.starts_with('"') && end < line.size()) {
    const std::string_view column = line.substr(1, end - 1);
    line.remove_prefix(end + 1);
    return column;
  }
  std::size_t size = 0;
  while (size < line.size() && !is_separator(line[size])) ++size;
  const std::string_view column = line.substr(0, size);
  line.remove_prefix(size);
  return column;
}

std::string_view number_with_comma(std::string_view line) {
  if (line.find(',') == std::string_view::npos) return {};
  constexpr std::string_view kOthers = " \t;";
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string_view found;
  std::size_t count = 0;
  for (std::size_t at = line.find_first_not_of(kOthers); at < line.size(); ++count) {
    const std::size_t end = std::min(line.find_first_of(kOthers, at), line.size());
    const std::string_view word = line.substr(at, end - at);
    at = line.find_first_not_of(kOthers, end);
    const std::size_t comma = word.find(',');
    if (comma == std::string_view::npos) continue;
    const bool is_inside = comma > 0 && comma + 1 < word.size() && is_digit(word[comma - 1]) &&
                           is_digit(word[comma + 1]);
    if (!is_inside || word.find(',', comma + 1) != std::string_view::npos) return {};
    if (found.empty()) found = word;
  }
  return count > 1 ? found : std::string_view();
}

namespace {

// Parts of the file are read on all threads; what a count promises is settled when they are joined.

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
