#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/write_gltf.h"

namespace planish {

/// The step of the coarsest grid on which every position moves by `error` at most, half a step in
/// each of three directions.
[[nodiscard]] double coarsest_step(double error);

/// Whole numbers for all positions: node.translation and node.scale carry the grid.
struct PositionGrid {
  glm::dvec3 origin{0.0};
  double step = 0;  ///< 0: float32 stays

  [[nodiscard]] glm::vec3 place(const glm::vec3& position) const {
    return glm::vec3(glm::round((glm::dvec3(position) - origin) / step));
  }
};

/// For packing positions within these bounds as coarse as options.position_error leaves room for,
/// else in 16 bits where those do.
[[nodiscard]] PositionGrid position_grid(const FloatBox& all, const GltfOptions& options);

/// Calls options.kept_float, if it is there and positions within these bounds stay float32.
void tell_kept_float(const GltfOptions& options, const FloatBox& bounds);

}  // namespace planish
