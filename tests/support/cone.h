#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// The side of a cone over the unit circle: `rings` circles of n vertices from the inside out, then
/// the apex at (0, 0, height); triangles around it, then quads.
inline PolygonMesh cone(int n, double height, int rings = 1) {
  PolygonMesh mesh;
  for (int ring = 1; ring <= rings; ++ring) {
    const double radius = static_cast<double>(ring) / rings;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                  (1 - radius) * height);
    }
  }
  mesh.positions.emplace_back(0, 0, height);
  for (int i = 0; i < n; ++i) mesh.add_face(std::vector{i, (i + 1) % n, n * rings});
  for (int ring = 1; ring < rings; ++ring) {
    const int inner = (ring - 1) * n, outer = ring * n;
    for (int i = 0; i < n; ++i)
      mesh.add_face(std::vector{outer + i, outer + (i + 1) % n, inner + (i + 1) % n, inner + i});
  }
  return mesh;
}

/// The face under its last circle.
inline PolygonMesh with_base(PolygonMesh cone, int n) {
  std::vector<std::int32_t> base;
  for (int i = 1; i <= n; ++i) base.push_back(cone.vertex_count() - 1 - i);
  cone.add_face(base);
  return cone;
}

}  // namespace planish::test
