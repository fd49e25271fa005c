#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/mesh/point_cloud.h"

namespace planish {

/// Columns behind x, y and z that are read.
inline constexpr std::size_t kMaxPointColumns = 40;

/// What the columns of points as text are: a first line may name them, else number and values tell
/// intensity, normals of unit length and colours from 0 to 255 apart, which a warning says.
struct PointColumns {
  std::vector<std::string> names;  ///< of all; empty: nobody names them
  std::size_t further = 0;         ///< behind x, y and z
  /// Where intensity, or intensity and colours, behind the place are the format's own.
  bool is_pts = false;
};

/// What is not as it should be in some columns of some points.
struct ColumnFaults {
  std::uint64_t columns = 0;  ///< by bit, those that lack a number somewhere
  std::int64_t line = 0;      ///< the first
  std::string what;

  void add(std::size_t column, std::int64_t at_line, std::string_view found);
};

/// Gives a cloud the numbers behind the places of its points, `columns.further` of each, as its
/// colours, normals and attributes. Warnings: "columns" where nobody names them, or they are left
/// out; "left-out-properties".
void add_columns(const PointColumns& columns, std::span<const float> values,
                 const ColumnFaults& faults, std::string_view file, PointCloud& cloud);

/// The words of a line that names columns, in small letters; empty unless x, y and z are among
/// them.
[[nodiscard]] std::vector<std::string> column_names(std::string_view line);

/// The next column of a line, behind which the line goes on; empty at its end. Quotes around it are
/// no part of it.
[[nodiscard]] std::string_view take_column(std::string_view& line);

/// A number with a comma in a line whose columns other signs separate, as `1,5 2,5 3,5` or
/// `1,5;2;3` have: the comma stands for a decimal point, or between thousands. Empty: there is
/// none, so that commas separate columns.
[[nodiscard]] std::string_view number_with_comma(std::string_view line);

}  // namespace planish
