#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/limit/adaptive_cells.h"
#include "planish/limit/adaptive_place.h"
#include "planish/limit/limit_surface.h"
#include "planish/patches/chart_field.h"

namespace planish {

/// u or v of a place, 0 to 1.
[[nodiscard]] inline double share_of_side(std::uint16_t parts) {
  return static_cast<double>(parts) / kCellSide;
}

/// What a field of a surface has at any place, for one thread; places of a corner come fastest
/// together.
template <class Vector>
class FieldAt {
 public:
  FieldAt(const LimitSurface& surface, const ChartField<Vector>& field)
      : surface_(surface), field_(field) {}

  /// At (u, v) of the corner's square.
  [[nodiscard]] Vector operator()(std::int32_t corner, const glm::dvec2& at) {
    if (at == glm::dvec2(0.0)) return field_.given(corner);
    if (corner != corner_) take(corner);
    Vector value = values_[0];
    for (int first = 0; first < Vector::length(); first += 3) {
      const PatchPoint point =
          patch_point(surface_.form(corner), points_[static_cast<std::size_t>(first / 3)],
                      {at.x, at.y}, scratch_);
      for (int d = first; d < std::min(first + 3, Vector::length()); ++d)
        value[d] += point.position[d - first];
    }
    return field_.row(value);
  }

 private:
  // Three numbers make a point.
  void take(std::int32_t corner) {
    corner_ = corner;
    field_.columns(surface_.surface().patches().corner_patch(corner), corner, indices_, values_);
    for (auto& points : points_) points.assign(values_.size(), glm::dvec3(0.0));
    for (std::size_t k = 0; k < values_.size(); ++k)
      for (int d = 0; d < Vector::length(); ++d)
        points_[static_cast<std::size_t>(d / 3)][k][d % 3] = values_[k][d] - values_[0][d];
  }

  const LimitSurface& surface_;
  const ChartField<Vector>& field_;
  std::int32_t corner_ = -1;
  std::vector<std::int32_t> indices_;
  std::vector<Vector> values_;
  std::array<std::vector<glm::dvec3>, (Vector::length() + 2) / 3> points_;
  PatchScratch scratch_;
};

/// result(i, value) at each place, on all threads: what a field of the surface has there, as levels
/// have it.
template <class Vector, class Result>
void field_at(const LimitSurface& surface, const ChartField<Vector>& field,
              std::span<const AdaptivePlace> places, const Result& result) {
  constexpr std::size_t kPlaces = std::size_t{1} << 12;
  parallel_for(places.size(), kPlaces, [&](std::size_t begin, std::size_t end) {
    FieldAt<Vector> at(surface, field);
    for (std::size_t i = begin; i < end; ++i)
      result(i, at(places[i].corner, {share_of_side(places[i].u), share_of_side(places[i].v)}));
  });
}

}  // namespace planish
