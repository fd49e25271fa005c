#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/triangles.h"
#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/triangle_shape.h"

namespace planish {

/// Finds nearest triangles (bounding-box hierarchy, split at the median of the centres). Queries
/// may run in parallel.
class TriangleTree {
 public:
  TriangleTree(std::span<const glm::dvec3> positions, std::span<const Triangle> triangles);
  TriangleTree(const OrderedPoints& positions, std::span<const Triangle> triangles);

  struct Hit {
    double squared_distance;
    std::int32_t triangle;  ///< -1 if there are no triangles
    std::int32_t place;     ///< of the triangle in the tree: where a search nearby may start
  };
  /// `start` is the place of a triangle that is likely to be near; -1: none is known. Of triangles
  /// that are equally near it decides which is found.
  [[nodiscard]] Hit nearest(const glm::dvec3& point, std::int32_t start = -1) const;

 private:
  struct Node {
    glm::dvec3 low, high;
    std::int32_t begin, end;  // of order_
    std::int32_t right = -1;  // the left child follows its parent; -1: a leaf
  };
  void build();
  void build(std::int32_t begin, std::int32_t end, std::span<const glm::dvec3> centres);

  std::vector<std::int32_t> order_;
  std::vector<TriangleShape> shapes_;  // in the order of order_
  std::vector<Node> nodes_;
};

/// Distances of points to a surface.
struct PointDistances {
  double max = 0, rms = 0;
  std::int64_t farthest = -1;  ///< index of the point at `max`
};

/// The distance of every point to the nearest of the triangles, which must not be empty unless
/// `points` is.
[[nodiscard]] PointDistances measure_distances(std::span<const glm::dvec3> points,
                                               std::span<const glm::dvec3> positions,
                                               std::span<const Triangle> triangles);

}  // namespace planish
