#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "planish/mesh/edge_groups.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

struct TriangleMesh {
  std::vector<glm::dvec3> positions;
  std::vector<Triangle> triangles;
};

/// Numbers of 0 to 1. Not std::uniform_real_distribution: its numbers differ between libraries.
inline double unit_number(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Points of a torus about z, radii 1 and 0.4, by rejection uniform in area.
inline std::vector<glm::dvec3> torus_points(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return unit_number(random); };
  std::vector<glm::dvec3> points;
  while (points.size() < count) {
    const double u = 2 * std::numbers::pi * unit(), v = 2 * std::numbers::pi * unit();
    const double ring = 1 + 0.4 * std::cos(v);
    if (unit() * 1.4 > ring) continue;
    points.emplace_back(ring * std::cos(u), ring * std::sin(u), 0.4 * std::sin(v));
  }
  return points;
}

inline double distance_to_torus(const glm::dvec3& p) {
  const double ring = std::hypot(p.x, p.y) - 1;
  return std::abs(std::hypot(ring, p.z) - 0.4);
}

inline double rms_distance_to_torus(const std::vector<glm::dvec3>& points) {
  double sum = 0;
  for (const glm::dvec3& p : points) sum += std::pow(distance_to_torus(p), 2);
  return std::sqrt(sum / static_cast<double>(points.size()));
}

/// Each coordinate moved by up to half of `width`.
inline void add_noise(std::vector<glm::dvec3>& points, double width, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (glm::dvec3& p : points)
    for (int axis = 0; axis < 3; ++axis) p[axis] += width * (unit_number(random) - 0.5);
}

/// A regular triangle mesh of the same torus.
inline TriangleMesh torus_mesh(std::int32_t around, std::int32_t across) {
  TriangleMesh mesh;
  for (std::int32_t i = 0; i < around; ++i) {
    for (std::int32_t j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
      const double ring = 1 + 0.4 * std::cos(v);
      mesh.positions.emplace_back(ring * std::cos(u), ring * std::sin(u), 0.4 * std::sin(v));
      const auto at = [&](std::int32_t a, std::int32_t b) {
        return (a % around) * across + b % across;
      };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

/// An open square grid in z = height(x, y), `size` by `size` squares of side 1.
template <class Height>
TriangleMesh grid_mesh(std::int32_t size, const Height& height) {
  TriangleMesh mesh;
  for (std::int32_t i = 0; i <= size; ++i)
    for (std::int32_t j = 0; j <= size; ++j) mesh.positions.emplace_back(i, j, height(i, j));
  const auto at = [&](std::int32_t i, std::int32_t j) { return i * (size + 1) + j; };
  for (std::int32_t i = 0; i < size; ++i) {
    for (std::int32_t j = 0; j < size; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

/// Puts another mesh, so far off, beside the first.
inline void append(TriangleMesh& mesh, const TriangleMesh& other, const glm::dvec3& off) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (const glm::dvec3& p : other.positions) mesh.positions.push_back(p + off);
  for (const Triangle& t : other.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

inline PolygonMesh polygons_of(const std::vector<glm::dvec3>& positions,
                               const std::vector<Triangle>& triangles) {
  PolygonMesh mesh = planish::polygons_of(triangles);
  mesh.positions = positions;
  return mesh;
}

/// Squared distance to a triangle, the long way: the foot on the plane if it is inside, else the
/// nearest of points on the edges.
inline double squared_distance(const glm::dvec3& p, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  bool inside = true;
  double best = INFINITY;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 a = t[i], b = t[(i + 1) % 3];
    inside = inside && glm::dot(glm::cross(b - a, p - a), normal) >= 0;
    const double s = std::fmin(1, std::fmax(0, glm::dot(p - a, b - a) / glm::dot(b - a, b - a)));
    best = std::fmin(best, glm::dot(p - a - s * (b - a), p - a - s * (b - a)));
  }
  if (!inside) return best;
  const double height = glm::dot(p - t[0], normal);
  return height * height / glm::dot(normal, normal);
}

/// The greatest distance of a position to the nearest triangle, trying every triangle.
inline double greatest_distance(const std::vector<glm::dvec3>& positions,
                                const std::vector<Triangle>& triangles) {
  double greatest = 0;
  for (const glm::dvec3& p : positions) {
    double best = INFINITY;
    for (const Triangle& t : triangles)
      best =
          std::fmin(best, squared_distance(p, {positions[t[0]], positions[t[1]], positions[t[2]]}));
    greatest = std::fmax(greatest, best);
  }
  return std::sqrt(greatest);
}

}  // namespace planish::test
