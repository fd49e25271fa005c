#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>

namespace planish::command {

/// An answer of `query` as PLY holds it. Without one `face` is -1, and the position is the point
/// that was asked for.
struct PlyAnswer {
  glm::dvec3 position{}, normal{};
  double distance = -1;  ///< of a closest point, or t of a ray
  std::int32_t face = -1;
  double u = 0, v = 0;
};

/// Binary PLY without faces: x, y, z, nx, ny, nz, `distance_name`, face, u, v, one vertex an
/// answer.
[[nodiscard]] std::string answers_ply(std::span<const PlyAnswer> answers,
                                      std::string_view distance_name);

}  // namespace planish::command
