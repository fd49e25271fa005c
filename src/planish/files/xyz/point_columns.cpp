#include "planish/files/xyz/point_columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/lower_case.h"
#include "planish/core/number_text.h"
#include "planish/files/shared/property_names.h"
#include "planish/files/shared/srgb.h"

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
      for (const std::size_t column : columns)
        square += std::pow(static_cast<double>((*this)(i, column)), 2);
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

}  // namespace planish
