#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace planish::viewer {

/// A shape that twists, sways and breathes about the upright axis through its middle. Smooth in
/// space and time; at rest at 0 seconds.
class Animation {
 public:
  explicit Animation(std::span<const glm::dvec3> rest);

  /// Writes the points at that time, one for each of the rest pose.
  void pose(double seconds, std::span<glm::vec3> points) const;

 private:
  std::vector<glm::dvec3> rest_;
  glm::dvec3 low_, size_;  // of the bounding box
};

}  // namespace planish::viewer
