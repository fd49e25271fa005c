#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

namespace planish {

/// The length of a vector whose squares may be too small or too large for double; infinite where a
/// coordinate is no finite number: of (0, NaN, 0) libstdc++'s hypot() says 0.
[[nodiscard]] inline double safe_length(const glm::dvec3& vector) {
  if (!std::isfinite(vector.x) || !std::isfinite(vector.y) || !std::isfinite(vector.z))
    return std::numeric_limits<double>::infinity();
  return std::hypot(vector.x, vector.y, vector.z);
}

}  // namespace planish
