#include "planish/stencil/level_counts.h"

namespace planish {

std::vector<LevelCounts> split_counts(const LevelCounts& base, std::int64_t corner_count,
                                      int last) {
  std::vector<LevelCounts> counts{base};
  for (int l = 0; l < last; ++l) {
    const LevelCounts& c = counts.back();
    counts.push_back({c.vertices + c.edges + c.faces, 2 * c.edges + corner_count, corner_count});
    corner_count *= 4;
  }
  return counts;
}

}  // namespace planish
