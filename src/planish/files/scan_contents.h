#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace planish {

/// What a scanner's file says besides its points.
struct ScanContents {
  /// Names as the file, or its format, has them, with what they count, in the file's order.
  using Counts = std::vector<std::pair<std::string, std::int64_t>>;

  std::string version;            ///< "LAS 1.2, point format 3, 34 bytes a point"
  std::string software;           ///< that wrote it
  std::string coordinate_system;  ///< as text; empty: not said
  Counts scans;                   ///< places or flight lines, with their points
  Counts classes;                 ///< of points
};

}  // namespace planish
