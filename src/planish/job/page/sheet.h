#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "planish/job/report.h"

namespace planish {

/// A file among many: what tells a bad surface from a good one, of an asset the sums and the worst
/// of its meshes.
struct SheetRow {
  std::string name;
  std::string page;     ///< the path of its own page from the sheet
  std::string failure;  ///< the message of a file that was not fitted; it has nothing else
  std::string method;
  std::int64_t vertices = 0, creases = 0, joined = 0, warnings = 0;
  std::int64_t meshes = 1;
  bool converged = true;
  bool is_measured = false;  ///< else the next two are unknown
  double normals = 0;        ///< degrees rms off the input's faces
  double folded = 0;         ///< of the area
  std::uint64_t bytes = 0;   ///< of all files that were written
  double milliseconds = 0;
  std::string given, surface;  ///< small pictures, PNG in base64; of an asset its largest mesh
};

/// All but name, page and pictures.
[[nodiscard]] SheetRow sheet_row(const JobReport& report);

/// Indices of rows, the worst first: those that failed, that missed the tolerance, that are folded
/// most, that have the most warnings, whose normals are farthest off.
[[nodiscard]] std::vector<std::size_t> worst_first(const std::vector<SheetRow>& rows);

/// A contact sheet: one HTML file that needs nothing else, a line and two pictures a file, as
/// worst_first() has them. `times`: also how long each took. `kind`: what they are.
[[nodiscard]] std::string make_sheet(const std::vector<SheetRow>& rows, bool times,
                                     std::string_view kind = "file");

}  // namespace planish
