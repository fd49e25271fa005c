#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/point_tree.h"

namespace planish {

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
