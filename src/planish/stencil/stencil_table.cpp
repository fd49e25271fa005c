#include "planish/stencil/stencil_table.h"

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

// LimitStencilTable has no other constructor than one that copies, and keeps its derivative weights
// private: give it nothing to copy, then move the rows into the vectors that its getters show. The
// object is not const, so writing through them is defined.
template <class Real>
LimitStencilTable<Real>::LimitStencilTable(std::int32_t source_count, StencilRows<Real>&& rows)
    : FarLimitStencilTable<Real>(source_count, {}, {}, {}, {}, {}, {}, {}, {}, {},
                                 /*includeCoarseVerts=*/false, /*firstOffset=*/0) {
  this->_sizes = std::move(rows.sizes);
  this->_indices = std::move(rows.indices);
  this->_weights = std::move(rows.weights);
  this->generateOffsets();
  const_cast<std::vector<Real>&>(this->GetDuWeights()) = std::move(rows.du_weights);
  const_cast<std::vector<Real>&>(this->GetDvWeights()) = std::move(rows.dv_weights);
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
