#include "planish/reconstruct/point_carrier.h"

#include <algorithm>
#include <limits>

namespace planish {
namespace {

// Takes the points and their nearest shapes.
void look(const OrderedPoints& positions, std::span<const std::int32_t> points,
          std::span<const TriangleShape> shapes, PointBatch& batch) {
  const std::size_t count = points.size();
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 place = positions[points[i]];
    batch.x[i] = place.x;
    batch.y[i] = place.y;
    batch.z[i] = place.z;
  }
  std::fill_n(batch.squared_distance, count, std::numeric_limits<double>::infinity());
  for (std::size_t s = 0; s < shapes.size(); ++s)
    take_nearer(shapes[s], static_cast<std::int32_t>(s), static_cast<int>(count), batch);
}

}  // namespace

std::int64_t find_nearest_shapes(const OrderedPoints& positions,
                                 std::span<const std::int32_t> points,
                                 std::span<const TriangleShape> shapes, double squared_tolerance,
                                 std::vector<std::int32_t>& nearest) {
  nearest.resize(points.size());
  PointBatch batch;
  for (std::size_t begin = 0; begin < points.size(); begin += kPointLanes) {
    const auto some =
        points.subspan(begin, std::min<std::size_t>(points.size() - begin, kPointLanes));
    look(positions, some, shapes, batch);
    for (std::size_t i = 0; i < some.size(); ++i)
      if (!(batch.squared_distance[i] <= squared_tolerance))
        return static_cast<std::int64_t>(begin + i);
    std::copy_n(batch.nearest, some.size(), nearest.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  return -1;
}

}  // namespace planish
