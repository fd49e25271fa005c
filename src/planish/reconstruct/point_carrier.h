#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/triangle_shape.h"

namespace planish {

/// Points that are no vertices any more, each carried by one triangle.
class PointCarrier {
 public:
  PointCarrier(std::size_t point_count, std::size_t triangle_count)
      : next_(point_count, -1), heads_(triangle_count, -1) {}

  void put(std::int32_t point, std::int32_t triangle) {
    next_[point] = heads_[triangle];
    heads_[triangle] = point;
  }
  /// Adds the points of a triangle to `points`; they stay where they are.
  void list(std::int32_t triangle, std::vector<std::int32_t>& points) const {
    for (std::int32_t p = heads_[triangle]; p >= 0; p = next_[p]) points.push_back(p);
  }
  void clear(std::int32_t triangle) { heads_[triangle] = -1; }

 private:
  std::vector<std::int32_t> next_, heads_;
};

/// Finds for each point the nearest shape. Stops and returns the place in `points` of the first
/// that is farther than the tolerance from every shape; -1 if there is none, `nearest` then holds
/// the index of each point's shape.
[[nodiscard]] std::int64_t find_nearest_shapes(const OrderedPoints& positions,
                                               std::span<const std::int32_t> points,
                                               std::span<const TriangleShape> shapes,
                                               double squared_tolerance,
                                               std::vector<std::int32_t>& nearest);

}  // namespace planish
