#include "planish/stencil/far_tables.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace planish {

namespace {

// A table's arrays without gaps between its rows, as OpenSubdiv copies them.
template <class Real>
struct FarArrays {
  explicit FarArrays(const StencilView<double>& table)
      : sizes(table.sizes.begin(), table.sizes.end()) {
    for (std::size_t row = 0; row < sizes.size(); ++row) {
      offsets.push_back(static_cast<int>(indices.size()));
      const auto first = static_cast<std::size_t>(table.offsets[row]);
      const auto append = [&](const auto& from, auto& to) {
        if (from.empty()) return;
        const auto entries = from.subspan(first, static_cast<std::size_t>(sizes[row]));
        to.insert(to.end(), entries.begin(), entries.end());
      };
      append(table.indices, indices);
      append(table.weights, weights);
      append(table.du_weights, du_weights);
      append(table.dv_weights, dv_weights);
    }
  }

  std::vector<int> sizes, offsets{}, indices{};
  std::vector<Real> weights{}, du_weights{}, dv_weights{};
};

// OpenSubdiv's constructors are protected.
template <class Real>
struct OwnTable : FarStencilTable<Real> {
  OwnTable(int source_count, const FarArrays<Real>& from)
      : FarStencilTable<Real>(source_count, from.offsets, from.sizes, from.indices, from.weights,
                              /*includeCoarseVerts=*/false, /*firstOffset=*/0) {}
};

template <class Real>
struct OwnLimitTable : FarLimitStencilTable<Real> {
  OwnLimitTable(int source_count, const FarArrays<Real>& from)
      : FarLimitStencilTable<Real>(source_count, from.offsets, from.sizes, from.indices,
                                   from.weights, from.du_weights, from.dv_weights, {}, {}, {},
                                   /*includeCoarseVerts=*/false, /*firstOffset=*/0) {}
};

}  // namespace

template <class Real>
std::unique_ptr<const FarStencilTable<Real>> to_far(const StencilView<double>& table) {
  return std::make_unique<const OwnTable<Real>>(table.source_count, FarArrays<Real>(table));
}

template <class Real>
std::unique_ptr<const FarLimitStencilTable<Real>> to_far_limit(const StencilView<double>& table) {
  return std::make_unique<const OwnLimitTable<Real>>(table.source_count, FarArrays<Real>(table));
}

template std::unique_ptr<const FarStencilTable<float>> to_far<float>(const StencilView<double>&);
template std::unique_ptr<const FarStencilTable<double>> to_far<double>(const StencilView<double>&);
template std::unique_ptr<const FarLimitStencilTable<float>> to_far_limit<float>(
    const StencilView<double>&);
template std::unique_ptr<const FarLimitStencilTable<double>> to_far_limit<double>(
    const StencilView<double>&);

}  // namespace planish
