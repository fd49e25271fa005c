#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "support/meshes.h"

namespace planish::testing {

/// A vertex of `hub` faces of `size` corners each, over an angle; closed where that is 2 pi.
[[nodiscard]] inline PolygonMesh hub_of(std::int32_t hub, std::int32_t size, double opening) {
  PolygonMesh mesh;
  mesh.positions.emplace_back(0, 0, 0.1);
  const std::int32_t steps = hub * (size - 2);
  const std::int32_t count = opening == 2 * std::numbers::pi ? steps : steps + 1;
  for (std::int32_t i = 0; i < count; ++i) {
    const double angle = opening * i / steps, radius = 0.5 + 0.02 * std::sin(5.0 * angle);
    mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                0.03 * std::cos(3.0 * angle));
  }
  for (std::int32_t f = 0; f < hub; ++f) {
    std::vector<std::int32_t> face = {0};
    for (std::int32_t i = 0; i < size - 1; ++i) face.push_back(1 + (f * (size - 2) + i) % count);
    mesh.add_face(face);
  }
  return mesh;
}

/// Rings of every kind that go by sums: large faces, smooth, a cone, a dart, beside a crease,
/// at a boundary, convex, of a half plane and reflex; of so many times 40 faces or corners.
[[nodiscard]] inline std::vector<test::NamedMesh> large_rings(std::int32_t times = 1) {
  constexpr double kPi = std::numbers::pi;
  std::vector<test::NamedMesh> meshes = {
      {"faces", hub_of(5, 40 * times, 2 * kPi)},     {"ring", hub_of(40 * times, 3, 2 * kPi)},
      {"cone", hub_of(40 * times, 3, 2 * kPi)},      {"dart", hub_of(40 * times, 3, 2 * kPi)},
      {"crease", hub_of(80 * times, 3, 2 * kPi)},    {"boundary", hub_of(50 * times, 3, 0.9 * kPi)},
      {"convex", hub_of(40 * times, 3, 0.45 * kPi)}, {"half plane", hub_of(40 * times, 4, kPi)},
      {"reflex", hub_of(41 * times, 3, 1.6 * kPi)}};
  for (const std::size_t i : {2, 6, 7, 8})
    meshes[i].mesh.corners.push_back({0, kInfiniteSharpness});
  meshes[3].mesh.creases.push_back({0, 8, kInfiniteSharpness});
  for (const std::int32_t spoke : {4, 39})
    meshes[4].mesh.creases.push_back({0, spoke, kInfiniteSharpness});
  return meshes;
}

}  // namespace planish::testing
