#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "planish/core/parallel.h"
#include "planish/limit/adaptive_cells.h"
#include "planish/limit/adaptive_place.h"
#include "planish/patches/patch_attributes.h"

namespace planish {

/// u or v of a place, 0 to 1.
[[nodiscard]] inline double share_of_side(std::uint16_t parts) {
  return static_cast<double>(parts) / kCellSide;
}

/// result(i, value) at each place, on all threads: bilinear between what at(corner) gives at the
/// mesh's corners, a vector of doubles, as levels have it.
template <class Vector, class At, class Result>
void bilinear_at(const MeshTopology& topology, std::span<const AdaptivePlace> places, const At& at,
                 const Result& result) {
  constexpr std::size_t kPlaces = std::size_t{1} << 12;
  parallel_for(places.size(), kPlaces, [&](std::size_t begin, std::size_t end) {
    std::int32_t corner = -1;
    std::array<Vector, 4> square{};
    for (std::size_t i = begin; i < end; ++i) {
      const AdaptivePlace& place = places[i];
      if (place.corner != corner) square = square_values(topology, place.corner, at);
      corner = place.corner;
      result(i, bilinear(square, share_of_side(place.u), share_of_side(place.v)));
    }
  });
}

}  // namespace planish
