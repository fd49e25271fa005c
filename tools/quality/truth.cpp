#include "quality/truth.h"

#include <glm/geometric.hpp>
#include <utility>

namespace planish::quality {

Truth true_sphere(double radius) {
  return [radius](const glm::dvec3& p) {
    const glm::dvec3 normal = glm::normalize(p);
    return Foot{radius * normal, normal};
  };
}

Truth true_torus(double radius, double tube_radius) {
  return [=](const glm::dvec3& p) {
    const glm::dvec3 middle = radius * glm::normalize(glm::dvec3(p.x, p.y, 0.0));
    const glm::dvec3 normal = glm::normalize(p - middle);
    return Foot{middle + tube_radius * normal, normal};
  };
}

Truth true_zero_set(shapes::Field field) {
  return [field = std::move(field)](const glm::dvec3& p) {
    constexpr double kLongestStep = 0.02;  // surfaces are that near to their shapes
    const glm::dvec3 foot = shapes::projected(field, p, kLongestStep);
    return Foot{foot, glm::normalize(shapes::gradient(field, foot))};
  };
}

}  // namespace planish::quality
