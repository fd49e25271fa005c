#include "planish/stencil/stencil_arrays.h"

#include <utility>

namespace planish {

StencilArrays arrays_of(const StencilView<double>& table) {
  StencilArrays arrays;
  arrays.source_count = table.source_count;
  arrays.sizes.assign(table.sizes.begin(), table.sizes.end());
  arrays.offsets.assign(table.offsets.begin(), table.offsets.end());
  arrays.indices.assign(table.indices.begin(), table.indices.end());
  arrays.weights.assign(table.weights.begin(), table.weights.end());
  return arrays;
}

StencilTable<double> table_of(const StencilArrays& arrays) {
  StencilRows<double> rows;
  rows.sizes.assign(arrays.sizes.begin(), arrays.sizes.end());
  rows.indices.assign(arrays.indices.begin(), arrays.indices.end());
  rows.weights.assign(arrays.weights.begin(), arrays.weights.end());
  return {arrays.source_count, std::move(rows)};
}

}  // namespace planish
