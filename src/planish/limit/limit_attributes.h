#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "planish/limit/limit_surface.h"

namespace planish {

/// The attribute of that index of the surface's mesh at places: its `width` numbers of each, one
/// place after another. Linear between vertices as on levels, whose rows have the same values.
/// Throws as LimitSurface::evaluate().
[[nodiscard]] std::vector<float> attribute_at(const LimitSurface& surface, std::size_t index,
                                              std::span<const SurfaceParameter> places);

}  // namespace planish
