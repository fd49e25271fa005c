#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/reconstruct/point_carrier.h"
#include "planish/reconstruct/triangle_change.h"

namespace planish {

/// Points that are no vertices any more, each within a tolerance of the triangle that carries it.
class CarriedPoints {
 public:
  /// Keeps the span of positions; the tolerance is a length.
  CarriedPoints(std::span<const glm::dvec3> positions, std::size_t triangle_count,
                double tolerance);

  /// Gives each of the points to the nearest triangle. Returns how many lie beyond the tolerance of
  /// all triangles; nobody carries those.
  [[nodiscard]] std::int64_t adopt(std::span<const std::int32_t> points,
                                   std::span<const Triangle> triangles);

  /// Adds the points that a triangle carries to `points`.
  void list(std::int32_t triangle, std::vector<std::int32_t>& points) const {
    carrier_.list(triangle, points);
  }

  /// Whether all points of the old triangles, and the removed vertex, stay within the tolerance of
  /// the new ones. The added vertex, one of those points, is carried no more.
  [[nodiscard]] bool can_move(const TriangleChange& change);
  /// Moves them, for the change that can_move() has just allowed.
  void move(const TriangleChange& change);
  /// To be called for each vertex whose triangles have changed.
  void forget_failure(std::int32_t vertex) { failures_[vertex] = -1; }

 private:
  std::span<const glm::dvec3> positions_;
  double squared_tolerance_;
  PointCarrier carrier_;
  std::vector<std::int32_t> failures_;  // by removed vertex: the point that stood in the way last
  std::vector<TriangleShape> shapes_;
  std::vector<std::int32_t> points_, nearest_;
};

}  // namespace planish
