#include "planish/mesh/split_keyhole.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numeric>

#include "planish/mesh/area_vector.h"

namespace planish {

namespace {

// Ears are looked for from every place after each cut: longer polygons would take minutes.
constexpr std::size_t kLongestKeyhole = 2000;

double double_area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The polygon in its plane, and what is left of it.
struct Keyholed {
  std::span<const std::int32_t> vertices;
  std::vector<glm::dvec2> points;
  std::vector<std::int32_t> left;  // places

  [[nodiscard]] std::array<std::int32_t, 3> ear(std::size_t i) const {
    return {left[(i + left.size() - 1) % left.size()], left[i], left[(i + 1) % left.size()]};
  }
  // Its area, or 0 where it is no ear.
  [[nodiscard]] double ear_area(std::size_t i) const {
    const std::array<std::int32_t, 3> corners = ear(i);
    const std::int32_t p = corners[0], q = corners[1], r = corners[2];
    if (vertices[p] == vertices[r]) return 0;  // both sides of a bridge
    const glm::dvec2 &a = points[p], &b = points[q], &c = points[r];
    const double area = double_area(a, b, c);
    if (!(area > 0)) return 0;
    const bool is_clear = std::ranges::none_of(left, [&](std::int32_t place) {
      const std::int32_t v = vertices[place];
      if (v == vertices[p] || v == vertices[q] || v == vertices[r]) return false;
      const glm::dvec2& d = points[place];
      return double_area(a, b, d) >= 0 && double_area(b, c, d) >= 0 && double_area(c, a, d) >= 0;
    });
    return is_clear ? area : 0;
  }
};

}  // namespace

std::vector<std::array<std::int32_t, 3>> split_keyhole(std::span<const glm::dvec3> positions,
                                                       std::span<const std::int32_t> polygon) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  const glm::dvec3 area = area_vector(positions, polygon);
  const double length = glm::length(area);
  if (polygon.size() > kLongestKeyhole || !(length > 0)) return {};
  const glm::dvec3 normal = area / length;
  const glm::dvec3 axis = std::abs(normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(axis, normal)), v = glm::cross(normal, u);
  Keyholed shape{polygon, {}, std::vector<std::int32_t>(polygon.size())};
  std::iota(shape.left.begin(), shape.left.end(), 0);
  for (const std::int32_t vertex : polygon) {
    const glm::dvec3 from = positions[vertex] - positions[polygon[0]];
    shape.points.emplace_back(glm::dot(from, u), glm::dot(from, v));
  }
  // Below this share of the whole an ear is a line, which rounding took for one.
  const double least = 1e-12 * length;
  while (shape.left.size() > 2) {
    std::size_t at = 0;
    while (at < shape.left.size() && !(shape.ear_area(at) > least)) ++at;
    if (at == shape.left.size()) return {};
    triangles.push_back(shape.ear(at));
    shape.left.erase(shape.left.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return triangles;
}

}  // namespace planish
