// Based on: L. Kobbelt, S. Campagna, H.-P. Seidel, "A General Framework for Mesh Decimation", 1998
// (a bound on the distance of the removed points).
#include "planish/reconstruct/carried_points.h"

#include <algorithm>
#include <limits>

namespace planish {

CarriedPoints::CarriedPoints(const OrderedPoints& points, std::span<const glm::dvec3> positions,
                             std::span<const std::int32_t> vertex_points,
                             std::span<const std::int32_t> carriers, std::size_t triangle_count,
                             double tolerance)
    : points_(points),
      positions_(positions),
      vertex_points_(vertex_points),
      squared_tolerance_(tolerance * tolerance),
      carrier_(points.size(), triangle_count),
      failures_(positions.size(), -1) {
  for (std::size_t point = 0; point < carriers.size(); ++point)
    if (carriers[point] >= 0) carrier_.put(static_cast<std::int32_t>(point), carriers[point]);
}

bool CarriedPoints::can_move(const TriangleChange& change) {
  shapes_.clear();
  for (const Triangle& t : change.triangles)
    shapes_.emplace_back(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
  moved_.clear();
  const std::int32_t vertex = change.removed_vertex;
  if (vertex >= 0) {
    // The point that stood in the way last time is likely to do so again.
    if (const std::int32_t suspect = failures_[vertex]; suspect >= 0) {
      const glm::dvec3 place = points_[suspect];
      double best = std::numeric_limits<double>::infinity();
      for (const TriangleShape& shape : shapes_)
        best = std::min(best, shape.squared_distance(place));
      if (!(best <= squared_tolerance_)) return false;
    }
    moved_.push_back(vertex_points_[vertex]);
  }
  for (const std::int32_t slot : change.old_slots) carrier_.list(slot, moved_);
  if (change.added_point >= 0) std::erase(moved_, change.added_point);
  const std::int64_t failed =
      find_nearest_shapes(points_, moved_, shapes_, squared_tolerance_, nearest_);
  if (failed >= 0 && vertex >= 0) failures_[vertex] = moved_[failed];
  return failed < 0;
}

void CarriedPoints::move(const TriangleChange& change) {
  for (const std::int32_t slot : change.old_slots) carrier_.clear(slot);
  for (std::size_t i = 0; i < moved_.size(); ++i)
    carrier_.put(moved_[i], change.slots[nearest_[i]]);
}

}  // namespace planish
