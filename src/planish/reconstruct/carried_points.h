#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/point_carrier.h"
#include "planish/reconstruct/triangle_change.h"

namespace planish {

/// Points that are no vertices any more, each within a tolerance of the triangle that carries it.
class CarriedPoints {
 public:
  /// Keeps the points, and the spans of the vertices' positions and points; the tolerance is a
  /// length. `carriers` names each point's triangle, -1 for none.
  CarriedPoints(const OrderedPoints& points, std::span<const glm::dvec3> positions,
                std::span<const std::int32_t> vertex_points, std::span<const std::int32_t> carriers,
                std::size_t triangle_count, double tolerance);

  /// Adds the points that a triangle carries to `points`.
  void list(std::int32_t triangle, std::vector<std::int32_t>& points) const {
    carrier_.list(triangle, points);
  }

  /// Whether all points of the old triangles, and the removed vertex, stay within the tolerance of
  /// the new ones. The added point, one of those, is carried no more.
  [[nodiscard]] bool can_move(const TriangleChange& change);
  /// Moves them, for the change that can_move() has just allowed.
  void move(const TriangleChange& change);
  /// To be called for each vertex whose triangles have changed.
  void forget_failure(std::int32_t vertex) { failures_[vertex] = -1; }

 private:
  const OrderedPoints& points_;
  std::span<const glm::dvec3> positions_;  // of vertices
  std::span<const std::int32_t> vertex_points_;
  double squared_tolerance_;
  PointCarrier carrier_;
  std::vector<std::int32_t> failures_;  // by removed vertex: the point that stood in the way last
  std::vector<TriangleShape> shapes_;
  std::vector<std::int32_t> moved_, nearest_;
};

}  // namespace planish
