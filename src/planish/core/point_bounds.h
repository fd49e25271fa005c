#pragma once

#include <glm/common.hpp>
#include <iterator>
#include <type_traits>

namespace planish {

/// Of the box around points.
template <class Point>
struct PointBounds {
  Point low, high;
};

/// Of points of two or three coordinates; the origin where there are none.
template <class Points>
[[nodiscard]] auto point_bounds(const Points& points) {
  using Point = std::remove_cvref_t<decltype(*std::begin(points))>;
  if (std::begin(points) == std::end(points)) return PointBounds<Point>{Point(0), Point(0)};
  PointBounds<Point> box{*std::begin(points), *std::begin(points)};
  for (const Point& point : points) {
    box.low = glm::min(box.low, point);
    box.high = glm::max(box.high, point);
  }
  return box;
}

}  // namespace planish
