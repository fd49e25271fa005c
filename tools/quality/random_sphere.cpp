#include "quality/random_sphere.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <utility>

#include "make_scenes/random_numbers.h"

namespace planish::quality {

std::vector<glm::dvec3> random_sphere_points(std::int32_t count, std::uint32_t seed) {
  shapes::RandomNumbers random(seed);
  std::vector<glm::dvec3> points;
  for (std::int32_t i = 0; i < count; ++i) {
    const double z = 2 * random.unit() - 1, angle = 2 * std::numbers::pi * random.unit();
    const double radius = std::sqrt(1 - z * z);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return points;
}

std::vector<Triangle> delaunay_on_sphere(const std::vector<glm::dvec3>& points) {
  const auto sees = [&](const glm::dvec3& p, const Triangle& t) {
    const glm::dvec3& origin = points[t[0]];
    return glm::dot(glm::cross(points[t[1]] - origin, points[t[2]] - origin), p - origin) > 0;
  };
  std::vector<Triangle> hull{{0, 1, 2}, {0, 2, 1}};
  // Every further point lies outside: what it sees gives way to a fan around the rim.
  for (std::int32_t p = 3; p < static_cast<std::int32_t>(points.size()); ++p) {
    std::set<std::pair<std::int32_t, std::int32_t>> rim;
    std::erase_if(hull, [&](const Triangle& t) {
      if (!sees(points[p], t)) return false;
      for (int k = 0; k < 3; ++k) {
        const std::int32_t a = t[k], b = t[(k + 1) % 3];
        if (rim.erase({b, a}) == 0) rim.insert({a, b});
      }
      return true;
    });
    for (const auto& [a, b] : rim) hull.push_back({a, b, p});
  }
  return hull;
}

}  // namespace planish::quality
