#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"

namespace planish {

/// The rows, of `count`, that are named or among the first so many, which stay; ascending. Names
/// become places in that list.
[[nodiscard]] std::vector<std::int32_t> rename_used(RawVector<std::int32_t>& names,
                                                    std::int64_t first, std::int64_t count);

/// Values of these rows only; ascending.
template <class T>
void keep_only(RawVector<T>& values, std::span<const std::int32_t> rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) values[i] = values[rows[i]];
  values.resize(rows.size());
}

}  // namespace planish
