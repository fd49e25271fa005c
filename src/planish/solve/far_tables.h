#pragma once

#include <opensubdiv/far/stencilTable.h>

#include <memory>
#include <type_traits>

#include "planish/solve/stencil_table.h"

namespace planish {

template <class Real>
using FarStencilTable =
    std::conditional_t<std::is_same_v<Real, float>, OpenSubdiv::Far::StencilTable,
                       OpenSubdiv::Far::StencilTableReal<Real>>;
template <class Real>
using FarLimitStencilTable =
    std::conditional_t<std::is_same_v<Real, float>, OpenSubdiv::Far::LimitStencilTable,
                       OpenSubdiv::Far::LimitStencilTableReal<Real>>;

/// A copy in OpenSubdiv's form, which every OpenSubdiv evaluator accepts; Real is float or double.
template <class Real>
[[nodiscard]] std::unique_ptr<const FarStencilTable<Real>> to_far(const StencilView<double>& table);

/// The same with the first derivatives that the table has.
template <class Real>
[[nodiscard]] std::unique_ptr<const FarLimitStencilTable<Real>> to_far_limit(
    const StencilView<double>& table);

}  // namespace planish
