#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/vectors.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish {

struct BoundingCube {
  glm::dvec3 low;
  double side;  ///< the largest extent of the points
};

[[nodiscard]] inline double largest_extent(const glm::dvec3& low, const glm::dvec3& high) {
  const glm::dvec3 extent = high - low;
  return std::max({extent.x, extent.y, extent.z});
}

/// Of at least one point.
[[nodiscard]] inline BoundingCube bounding_cube(std::span<const glm::dvec3> points) {
  const auto [low, high] = point_bounds(points);
  return {low, largest_extent(low, high)};
}

/// The indices of finite points in the order of a Z-curve through their bounding box: points that
/// are near in the result are near in space, so that arrays in this order stay in the cache. Those
/// at one place follow each other, ascending.
/// Source: G. M. Morton, "A Computer Oriented Geodetic Data Base", 1966.
[[nodiscard]] std::vector<std::int32_t> spatial_order(std::span<const glm::dvec3> points);

struct Neighbour {
  double squared_distance;
  std::int32_t index;
};

/// Finds nearest points (k-d tree, split at medians). Copies the points; queries may run in
/// parallel.
class PointTree {
 public:
  explicit PointTree(std::span<const glm::dvec3> points);

  /// Fills `nearest` with the points nearest to `query`, nearest first, a point at `query` itself
  /// included. Returns how many there are, nearest.size() unless the cloud is smaller.
  std::size_t find_nearest(const glm::dvec3& query, std::span<Neighbour> nearest) const;

 private:
  struct Search;
  void build(std::int32_t begin, std::int32_t end);
  void search(std::int32_t begin, std::int32_t end, Search& state) const;

  std::vector<std::int32_t> indices_;  // in tree order: a node's point stands in its middle
  std::vector<glm::dvec3> points_;     // in tree order
  std::vector<std::uint8_t> axes_;     // of the split at each middle
};

/// Finds nearest points among points along a Z-curve: bounding boxes of runs of them, and of runs
/// of boxes; 4 bytes a point. Queries may run in parallel.
class OrderedTree {
 public:
  /// Keeps a reference to the points, which must not change.
  explicit OrderedTree(const OrderedPoints& points);

  /// As PointTree::find_nearest(), from the run of the point `start`, which should be near. Of
  /// equally near points that of lowest index is nearest.
  std::size_t find_nearest(const glm::dvec3& query, std::int32_t start,
                           std::span<Neighbour> nearest) const;

 private:
  struct Box {
    glm::vec3 low, high;  // rounded outwards
  };
  struct Search;
  void visit(std::size_t level, std::size_t box, Search& search) const;

  const OrderedPoints& points_;
  std::vector<std::vector<Box>>
      levels_;  // of runs of points first, then of boxes; the last has one
};

}  // namespace planish
