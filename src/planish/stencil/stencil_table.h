#pragma once

#include <opensubdiv/far/stencilTable.h>

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace planish {

/// Read-only view of a stencil table: row i is sum over k in [offsets[i], offsets[i] + sizes[i])
/// of weights[k] * source[indices[k]]. This is what backends take.
template <class Real>
struct StencilView {
  std::int32_t source_count = 0;
  std::span<const std::int32_t> sizes, offsets, indices;
  std::span<const Real> weights;

  [[nodiscard]] std::int32_t row_count() const { return static_cast<std::int32_t>(sizes.size()); }
};

/// A view with derivative weights beside the position weights, on the same indices.
template <class Real>
struct LimitStencilView : StencilView<Real> {
  std::span<const Real> du_weights, dv_weights;
};

/// Plain rows on their way into a table. Offsets follow from sizes.
template <class Real>
struct StencilRows {
  std::vector<std::int32_t> sizes, indices;
  std::vector<Real> weights;
  std::vector<Real> du_weights, dv_weights;  ///< empty, or as long as weights
};

/// A Far::StencilTable (float) or Far::StencilTableReal<double> made of given rows, so that every
/// OpenSubdiv evaluator accepts it.
template <class Real>
using FarStencilTable =
    std::conditional_t<std::is_same_v<Real, float>, OpenSubdiv::Far::StencilTable,
                       OpenSubdiv::Far::StencilTableReal<Real>>;
template <class Real>
using FarLimitStencilTable =
    std::conditional_t<std::is_same_v<Real, float>, OpenSubdiv::Far::LimitStencilTable,
                       OpenSubdiv::Far::LimitStencilTableReal<Real>>;

template <class Real>
class StencilTable : public FarStencilTable<Real> {
 public:
  StencilTable(std::int32_t source_count, StencilRows<Real>&& rows);
  [[nodiscard]] StencilView<Real> view() const;
};

/// The same with first derivatives.
template <class Real>
class LimitStencilTable : public FarLimitStencilTable<Real> {
 public:
  LimitStencilTable(std::int32_t source_count, StencilRows<Real>&& rows);
  [[nodiscard]] LimitStencilView<Real> view() const;
};

extern template class StencilTable<float>;
extern template class StencilTable<double>;
extern template class LimitStencilTable<float>;
extern template class LimitStencilTable<double>;

}  // namespace planish
