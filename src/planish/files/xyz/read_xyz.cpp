#include "planish/files/xyz/read_xyz.h"

#include <array>
#include <cmath>
#include <string>

#include "planish/core/number_text.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

enum class TextPoints { Xyz, Pts };

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

bool is_nan(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  return word == "nan" || word == "NaN" || word == "NAN";
}

class TextPointReader {
 public:
  TextPointReader(std::span<const std::byte> bytes, std::string_view name, TextPoints kind)
      : name_(name), lines_(bytes, name), kind_(kind) {}

  PointCloud read() {
    while (lines_.next()) read_line(lines_.line());
    if (promised_ > read_since_promise_)
      lines_.fail("the file ends after " + std::to_string(read_since_promise_) + " of " +
                  std::to_string(promised_) + " points");
    if (excess_.count > 0) warn_of_excess();
    return std::move(cloud_);
  }

 private:
  void read_line(std::string_view line) {
    std::string_view rest = line;
    std::array<std::string_view, 3> columns;
    columns[0] = take_column(rest);
    if (columns[0].empty() || columns[0].starts_with('#') || columns[0].starts_with("//")) return;
    columns[1] = take_column(rest);
    columns[2] = take_column(rest);
    if (kind_ == TextPoints::Pts && columns[1].empty()) {
      read_count(columns[0]);
      return;
    }
    if (is_column_names(columns[0])) return;
    read_point(columns);
  }

  // Some programs name the columns in the first line.
  bool is_column_names(std::string_view word) {
    const bool first = !has_content_;
    has_content_ = true;
    double ignored = 0;
    const char c = word.front();
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '"';
    return first && is_letter && !is_nan(word) && !parse_number(word, ignored);
  }

  void read_count(std::string_view word) {
    std::int64_t count = 0;
    if (!parse_integer(word, count) || count < 0)
      lines_.fail("point count " + quote(word) + " is no integer from 0");
    if (promised_ > read_since_promise_)
      lines_.fail("a point count stands after " + std::to_string(read_since_promise_) + " of " +
                  std::to_string(promised_) + " points");
    promised_ = count;
    promise_line_ = lines_.number();
    read_since_promise_ = 0;
    has_content_ = true;
  }

  void note_excess(std::int64_t index) {
    if (excess_.count++ == 0) excess_ = {1, index, lines_.number(), promised_, promise_line_};
  }

  // All are there, so that nothing is lost.
  void warn_of_excess() {
    cloud_.warnings.push_back(
        {.code = "point-count",
         .message = name_ + ":" + std::to_string(excess_.line) + ": " +
                    std::to_string(excess_.count) + " points stand behind the " +
                    std::to_string(excess_.promised) + " that line " +
                    std::to_string(excess_.promise_line) + " counts; they are read as well",
         .count = excess_.count,
         .first = excess_.first});
  }

  void read_point(const std::array<std::string_view, 3>& columns) {
    const auto index = static_cast<std::int64_t>(cloud_.points.size()) + cloud_.missing_count;
    if (columns[2].empty()) lines_.fail("a point needs 3 coordinates", index);
    glm::dvec3 point(0.0);
    bool missing = false;
    for (int axis = 0; axis < 3; ++axis) {
      if (is_nan(columns[axis])) {
        missing = true;
      } else if (!parse_number(columns[axis], point[axis]) ||
                 std::abs(point[axis]) > kMaxCoordinate) {
        lines_.fail("coordinate " + quote(columns[axis]) + " is no finite number up to 1e150",
                    index);
      }
    }
    ++read_since_promise_;
    if (promise_line_ > 0 && read_since_promise_ > promised_) note_excess(index);
    if (missing) {
      ++cloud_.missing_count;
    } else {
      cloud_.points.push_back(point);
    }
  }

  std::string name_;
  TextLines lines_;
  TextPoints kind_;
  PointCloud cloud_;
  bool has_content_ = false;
  std::int64_t promised_ = 0, read_since_promise_ = 0, promise_line_ = 0;
  // Points that no count promises: the first, its line, and the count before it.
  struct Excess {
    std::int64_t count = 0, first = -1, line = 0, promised = 0, promise_line = 0;
  };
  Excess excess_;
};

}  // namespace

PointCloud read_xyz(std::span<const std::byte> bytes, std::string_view name) {
  return TextPointReader(bytes, name, TextPoints::Xyz).read();
}

PointCloud read_pts(std::span<const std::byte> bytes, std::string_view name) {
  return TextPointReader(bytes, name, TextPoints::Pts).read();
}

}  // namespace planish
