#pragma once

#include <cstdint>

#include "planish/core/raw_vector.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// A stencil table in arrays that threads fill, for those who need no Far::StencilTable: making one
/// of those touches its memory twice.
struct StencilArrays {
  std::int32_t source_count = 0;
  RawVector<std::int32_t> sizes, offsets, indices;
  RawVector<double> weights;

  [[nodiscard]] StencilView<double> view() const {
    StencilView<double> view;
    view.source_count = source_count;
    view.sizes = sizes;
    view.offsets = offsets;
    view.indices = indices;
    view.weights = weights;
    return view;
  }
};

/// A copy of a table without gaps between its rows.
[[nodiscard]] StencilArrays arrays_of(const StencilView<double>& table);
[[nodiscard]] StencilTable<double> table_of(const StencilArrays& arrays);

}  // namespace planish
