#include "planish/limit/used_rows.h"

#include <algorithm>

namespace planish {

std::vector<std::int32_t> rename_used(RawVector<std::int32_t>& names, std::int64_t first,
                                      std::int64_t count) {
  std::vector<std::int32_t> place(static_cast<std::size_t>(count), 0);
  std::fill(place.begin(), place.begin() + first, 1);
  for (const std::int32_t row : names) place[row] = 1;
  std::vector<std::int32_t> rows;
  for (std::size_t row = 0; row < place.size(); ++row) {
    if (place[row] == 0) continue;
    place[row] = static_cast<std::int32_t>(rows.size());
    rows.push_back(static_cast<std::int32_t>(row));
  }
  for (std::int32_t& row : names) row = place[row];
  return rows;
}

}  // namespace planish
