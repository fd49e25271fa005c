#include "bench/moving_torus.h"

#include <cmath>
#include <numbers>
#include <random>

#include "bench/bench_meshes.h"

namespace planish::bench {

namespace {

constexpr double kFramesPerSecond = 60;
constexpr double kTwist = 0.5;      // radians a unit of length
constexpr double kRoughness = 0.1;  // of an edge

}  // namespace

PolygonMesh rough_torus(std::int32_t point_count) {
  PolygonMesh mesh = torus_grid(point_count);
  // Along the circle R = 1; those of the tube are shorter.
  const double edge = 2 * std::numbers::pi / std::sqrt(mesh.vertex_count());
  std::mt19937 random(1);
  for (glm::dvec3& position : mesh.positions)
    // The generator's own numbers: standard distributions differ between libraries.
    for (int k = 0; k < 3; ++k)
      position[k] += kRoughness * edge * (2 * (random() / 4294967295.0) - 1);
  return mesh;
}

std::vector<glm::vec3> twisted(const PolygonMesh& rest, int frame) {
  const double twist = kTwist * std::sin(2 * std::numbers::pi * frame / kFramesPerSecond);
  std::vector<glm::vec3> pose;
  pose.reserve(rest.positions.size());
  for (const glm::dvec3& p : rest.positions) {
    const double sine = std::sin(twist * p.x), cosine = std::cos(twist * p.x);
    pose.emplace_back(p.x, cosine * p.y - sine * p.z, sine * p.y + cosine * p.z);
  }
  return pose;
}

}  // namespace planish::bench
