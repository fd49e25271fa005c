// Based on: Inigo Quilez, "Distance functions" and "Smooth minimum", 2013.
#include "make_scenes/implicit.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace planish::shapes {

double Ellipsoid::operator()(const glm::dvec3& p) const {
  const glm::dvec3 scaled = (p - centre) / radii;
  const double level = glm::length(scaled);
  const double slope = glm::length(scaled / radii);
  if (slope < 1e-12) return -std::min({radii.x, radii.y, radii.z});
  return level * (level - 1.0) / slope;
}

double Cone::operator()(const glm::dvec3& p) const {
  const glm::dvec3 axis = b - a;
  const double t = std::clamp(glm::dot(p - a, axis) / glm::dot(axis, axis), 0.0, 1.0);
  return glm::distance(p, a + axis * t) - (radius_a + (radius_b - radius_a) * t);
}

double extruded(double distance, double height, double half_height, double rounding) {
  const glm::dvec2 over(distance + rounding, std::abs(height) - half_height + rounding);
  return std::min(std::max(over.x, over.y), 0.0) + glm::length(glm::max(over, glm::dvec2(0.0))) -
         rounding;
}

double rounded_box(const glm::dvec3& p, const glm::dvec3& half_size, double rounding) {
  const glm::dvec3 over = glm::abs(p) - half_size + rounding;
  return std::min(std::max({over.x, over.y, over.z}), 0.0) +
         glm::length(glm::max(over, glm::dvec3(0.0))) - rounding;
}

double smooth_union(double a, double b, double width) {
  const double overlap = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - overlap * overlap * width * 0.25;
}

double smooth_intersection(double a, double b, double width) {
  return -smooth_union(-a, -b, width);
}

double smooth_difference(double a, double b, double width) { return -smooth_union(-a, b, width); }

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace planish::shapes
