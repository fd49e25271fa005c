#include "planish/stencil/stencil_table.h"

#include <cstddef>
#include <utility>

namespace planish {

namespace {

template <class Real>
StencilView<Real> view_of(const OpenSubdiv::Far::StencilTableReal<Real>& table) {
  StencilView<Real> view;
  view.source_count = table.GetNumControlVertices();
  view.sizes = table.GetSizes();
  view.offsets = table.GetOffsets();
  view.indices = table.GetControlIndices();
  view.weights = table.GetWeights();
  return view;
}

}  // namespace

// OpenSubdiv's protected default constructor leaves the vectors empty for derived classes: fill
// them by move, since the constructor that takes them copies.
template <class Real>
StencilTable<Real>::StencilTable(std::int32_t source_count, StencilRows<Real>&& rows)
    : FarStencilTable<Real>(source_count) {
  this->_sizes = std::move(rows.sizes);
  this->_indices = std::move(rows.indices);
  this->_weights = std::move(rows.weights);
  this->generateOffsets();
}

template <class Real>
StencilView<Real> StencilTable<Real>::view() const {
  return view_of<Real>(*this);
}

namespace {

std::vector<int> offsets_of(const std::vector<std::int32_t>& sizes) {
  std::vector<int> offsets(sizes.size());
  int offset = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    offsets[i] = offset;
    offset += sizes[i];
  }
  return offsets;
}

}  // namespace

// LimitStencilTable has no other constructor than the copying one.
template <class Real>
LimitStencilTable<Real>::LimitStencilTable(std::int32_t source_count, StencilRows<Real>&& rows)
    : FarLimitStencilTable<Real>(source_count, offsets_of(rows.sizes), rows.sizes, rows.indices,
                                 rows.weights, rows.du_weights, rows.dv_weights, {}, {}, {},
                                 /*includeCoarseVerts=*/false, /*firstOffset=*/0) {
  rows = {};
}

template <class Real>
LimitStencilView<Real> LimitStencilTable<Real>::view() const {
  LimitStencilView<Real> view;
  static_cast<StencilView<Real>&>(view) = view_of<Real>(*this);
  view.du_weights = this->GetDuWeights();
  view.dv_weights = this->GetDvWeights();
  return view;
}

template class StencilTable<float>;
template class StencilTable<double>;
template class LimitStencilTable<float>;
template class LimitStencilTable<double>;

}  // namespace planish
