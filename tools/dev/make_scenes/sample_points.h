#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// Random numbers that are the same with every standard library (its distributions are not).
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint32_t seed) : engine_(seed) {}

  /// Even in [0, 1).
  double unit() { return engine_() * 0x1p-32; }
  /// Even in [-1, 1).
  double sway() { return 2 * unit() - 1; }
  /// Even in [0, count), count >= 1.
  std::int32_t below(std::int32_t count) { return static_cast<std::int32_t>(unit() * count); }

 private:
  std::mt19937 engine_;
};

/// Points on the faces of a mesh, each cut into a fan: independent, even in area. The mesh must
/// have some area. The same for the same seed everywhere.
[[nodiscard]] std::vector<glm::dvec3> sample_uniform(const PolygonMesh& mesh, std::int32_t count,
                                                     std::uint32_t seed);

/// Points on the faces of a mesh, no two nearer to each other than a radius that is nearly the
/// largest for which `count` are found by throwing darts.
[[nodiscard]] std::vector<glm::dvec3> sample_poisson_disk(const PolygonMesh& mesh,
                                                          std::int32_t count, std::uint32_t seed);

/// Moves every point by normal noise of that standard deviation along each axis.
void add_noise(std::span<glm::dvec3> points, double deviation, std::uint32_t seed);

/// Adds points that are even in the bounding box.
void add_outliers(std::vector<glm::dvec3>& points, std::int32_t count, std::uint32_t seed);

/// The bytes of a PLY file, binary, float.
[[nodiscard]] std::string ply_text(std::span<const glm::dvec3> points);

}  // namespace planish::shapes
