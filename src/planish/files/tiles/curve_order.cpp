// Based on: J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707, 2004.
#include "planish/files/tiles/curve_order.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

#include "planish/core/parallel.h"
#include "planish/core/point_bounds.h"

namespace planish {
namespace {

constexpr std::size_t kGrain = std::size_t{1} << 13;

struct Place {
  std::uint64_t key;
  std::int32_t point;
  [[nodiscard]] bool operator<(const Place& other) const {
    return key != other.key ? key < other.key : point < other.point;
  }
};

std::uint32_t cell_of(double offset, double side) {
  constexpr double kCells = std::uint32_t{1} << kCurveBits;
  const double at = side > 0 ? offset / side * kCells : 0.0;
  // The comparison is false for what is not finite.
  return at > 0 ? static_cast<std::uint32_t>(std::min(at, kCells - 1)) : 0;
}

}  // namespace

CurveBox curve_box(std::span<const glm::dvec3> points) {
  if (points.empty()) return {};
  const auto [low, high] = point_bounds(points);
  const glm::dvec3 size = high - low;
  return {low, std::max({size.x, size.y, size.z})};
}

std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t axes[3] = {x, y, z};
  constexpr std::uint32_t kTop = std::uint32_t{1} << (kCurveBits - 1);
  // Undoes the turns of the cubes around the cell, from the largest down.
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1) {
    const std::uint32_t below = bit - 1;
    for (std::uint32_t& axis : axes) {
      if ((axis & bit) != 0) {
        axes[0] ^= below;
      } else {
        const std::uint32_t swapped = (axes[0] ^ axis) & below;
        axes[0] ^= swapped;
        axis ^= swapped;
      }
    }
  }
  // Gray code.
  axes[1] ^= axes[0];
  axes[2] ^= axes[1];
  std::uint32_t flip = 0;
  for (std::uint32_t bit = kTop; bit > 1; bit >>= 1)
    if ((axes[2] & bit) != 0) flip ^= bit - 1;
  std::uint64_t key = 0;
  for (std::uint32_t bit = kCurveBits; bit-- > 0;)
    for (const std::uint32_t axis : axes) key = key << 1 | ((axis ^ flip) >> bit & 1);
  return key;
}

std::uint64_t hilbert_key(const glm::dvec3& point, const CurveBox& box) {
  const glm::dvec3 offset = point - box.lower;
  return hilbert_key(cell_of(offset.x, box.side), cell_of(offset.y, box.side),
                     cell_of(offset.z, box.side));
}

RawVector<std::int32_t> curve_order(std::span<const glm::dvec3> points) {
  const CurveBox box = curve_box(points);
  RawVector<Place> places(points.size());
  parallel_each(points.size(), kGrain, [&](std::int32_t i) {
    places[i] = {hilbert_key(points[i], box), i};
  });
  oneapi::tbb::parallel_sort(places.begin(), places.end());
  RawVector<std::int32_t> order(points.size());
  parallel_each(points.size(), kGrain, [&](std::size_t i) { order[i] = places[i].point; });
  return order;
}

}  // namespace planish
