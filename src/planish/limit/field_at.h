#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/limit/adaptive_place.h"
#include "planish/limit/bilinear_at.h"
#include "planish/limit/limit_surface.h"
#include "planish/patches/chart_field.h"

namespace planish {

/// result(i, value) at each place, on all threads: what a field of the surface has there, as levels
/// have it.
template <class Vector, class Result>
void field_at(const LimitSurface& surface, const ChartField<Vector>& field,
              std::span<const AdaptivePlace> places, const Result& result) {
  static_assert(Vector::length() <= 3);
  constexpr std::size_t kPlaces = std::size_t{1} << 12;
  const PatchMesh& mesh = surface.surface().patches();
  parallel_for(places.size(), kPlaces, [&](std::size_t begin, std::size_t end) {
    std::int32_t corner = -1;
    std::vector<std::int32_t> indices;
    std::vector<Vector> values;
    std::vector<glm::dvec3> points;
    PatchScratch scratch;
    for (std::size_t i = begin; i < end; ++i) {
      const AdaptivePlace& place = places[i];
      if (place.corner != corner) {
        corner = place.corner;
        field.columns(mesh.corner_patch(corner), corner, indices, values);
        points.assign(values.size(), glm::dvec3(0.0));
        for (std::size_t k = 0; k < values.size(); ++k)
          for (int d = 0; d < Vector::length(); ++d) points[k][d] = values[k][d] - values[0][d];
      }
      if (place.u == 0 && place.v == 0) {
        result(i, field.given(corner));
        continue;
      }
      const PatchPoint point = patch_point(
          surface.form(corner), points, {share_of_side(place.u), share_of_side(place.v)}, scratch);
      Vector value = values[0];
      for (int d = 0; d < Vector::length(); ++d) value[d] += point.position[d];
      result(i, value);
    }
  });
}

}  // namespace planish
