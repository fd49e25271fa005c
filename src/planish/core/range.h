#pragma once

#include <cstdint>

namespace planish {

/// A range of rows of a table.
struct RowRange {
  std::int64_t first, count;
};

}  // namespace planish
