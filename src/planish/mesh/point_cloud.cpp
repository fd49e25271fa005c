#include "planish/mesh/point_cloud.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/point_bounds.h"
#include "planish/mesh/check.h"

namespace planish {

double diagonal_of(std::span<const glm::dvec3> points) {
  const auto [low, high] = point_bounds(points);
  return glm::length(high - low);
}

void recentre(PointCloud& cloud) {
  const auto [low, high] = point_bounds(cloud.points);
  const double diagonal = glm::length(high - low);
  if (!(diagonal > 0)) return;
  // A multiple of a power of two above the diagonal: then every difference has fewer bits than
  // the coordinate it came from and is exact.
  const double grain = std::ldexp(1.0, std::ilogb(diagonal) + 1);
  for (int axis = 0; axis < 3; ++axis) {
    const double centre = 0.5 * low[axis] + 0.5 * high[axis];
    if (std::abs(centre) > kFarDiagonals * diagonal)
      cloud.origin[axis] = std::round(centre / grain) * grain;
  }
  if (cloud.origin == glm::dvec3(0.0)) return;
  for (glm::dvec3& point : cloud.points) point -= cloud.origin;
}

PointCloud cloud_of(std::vector<glm::dvec3> positions, std::string_view name) {
  for (std::size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(positions[i][axis]) <= kMaxCoordinate))
        throw Error(ErrorCode::UnreadableInput,
                    formatted("{}: point {} of {}: a coordinate is beyond 1e150", name, i,
                              positions.size()),
                    static_cast<std::int64_t>(i));
  PointCloud cloud{.points = std::move(positions)};
  recentre(cloud);
  return cloud;
}

}  // namespace planish
