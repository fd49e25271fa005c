// Based on: L. Kobbelt, S. Campagna, H.-P. Seidel, "A General Framework for Mesh Decimation", 1998
// (a bound on the distance of the removed points).
#include "planish/reconstruct/carried_points.h"

#include <algorithm>
#include <limits>

#include "planish/reconstruct/triangle_tree.h"

namespace planish {

CarriedPoints::CarriedPoints(std::span<const glm::dvec3> positions, std::size_t triangle_count,
                             double tolerance)
    : positions_(positions),
      squared_tolerance_(tolerance * tolerance),
      carrier_(positions.size(), triangle_count),
      failures_(positions.size(), -1) {}

std::int64_t CarriedPoints::adopt(std::span<const std::int32_t> points,
                                  std::span<const Triangle> triangles) {
  if (points.empty() || triangles.empty()) return 0;
  const TriangleTree tree(positions_, triangles);
  std::int64_t strayed = 0;
  for (const std::int32_t point : points) {
    const TriangleTree::Hit hit = tree.nearest(positions_[point]);
    if (hit.squared_distance <= squared_tolerance_) {
      carrier_.put(point, hit.triangle);
    } else {
      ++strayed;
    }
  }
  return strayed;
}

bool CarriedPoints::can_move(const TriangleChange& change) {
  shapes_.clear();
  for (const Triangle& t : change.triangles)
    shapes_.emplace_back(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  points_.clear();
  const std::int32_t vertex = change.removed_vertex;
  if (vertex >= 0) {
    // The point that stood in the way last time is likely to do so again.
    if (const std::int32_t suspect = failures_[vertex]; suspect >= 0) {
      double best = std::numeric_limits<double>::infinity();
      for (const TriangleShape& shape : shapes_)
        best = std::min(best, shape.squared_distance(positions_[suspect]));
      if (!(best <= squared_tolerance_)) return false;
    }
    points_.push_back(vertex);
  }
  for (const std::int32_t slot : change.old_slots) carrier_.list(slot, points_);
  if (change.added_vertex >= 0) std::erase(points_, change.added_vertex);
  const std::int64_t failed =
      find_nearest_shapes(positions_, points_, shapes_, squared_tolerance_, nearest_);
  if (failed >= 0 && vertex >= 0) failures_[vertex] = points_[failed];
  return failed < 0;
}

void CarriedPoints::move(const TriangleChange& change) {
  for (const std::int32_t slot : change.old_slots) carrier_.clear(slot);
  for (std::size_t i = 0; i < points_.size(); ++i)
    carrier_.put(points_[i], change.slots[nearest_[i]]);
}

}  // namespace planish
