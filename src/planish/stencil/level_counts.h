#pragma once

#include <cstdint>
#include <vector>

namespace planish {

/// Element counts of one level of refinement.
struct LevelCounts {
  std::int64_t vertices, edges, faces;
};

/// Those of the levels 0 to `last` of a mesh with so many elements and corners, every face of which
/// is cut into quads at each step: a quad a corner.
[[nodiscard]] std::vector<LevelCounts> split_counts(const LevelCounts& base,
                                                    std::int64_t corner_count, int last);

}  // namespace planish
