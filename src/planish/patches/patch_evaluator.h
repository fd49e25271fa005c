#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/patches/patch_surface.h"

namespace planish {

/// What a backend also is that evaluates patches on its device. For the others there is
/// PatchSurface::rows().
class PatchEvaluator {
 public:
  virtual ~PatchEvaluator() = default;

  struct Row {
    glm::vec3 position;  ///< in the coordinates of the state
    glm::vec3 normal;    ///< zero where tangents are parallel
  };

  /// All rows of a surface with these points of level 1, in the device's precision. Throws
  /// Error{OutOfMemory}, naming the limit, and Error{DeviceLost}.
  virtual void evaluate_patches(const PatchSurface& surface, std::span<const glm::dvec3> state,
                                std::span<Row> rows) = 0;
};

}  // namespace planish
