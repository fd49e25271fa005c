#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// A closed body of faces on surfaces that have a name, and of others between.
struct MixedShape {
  std::string name;
  PolygonMesh mesh;
  std::array<std::int64_t, kAnalyticKinds> kinds;  ///< of faces
};

// A surface of revolution about z up to a wavy border, and a bumpy lid on that. `at`: its point at
// an angle and from 0, where a disc closes it or the axis is, to 1.
inline PolygonMesh lidded(const std::function<glm::dvec3(double, double)>& at) {
  constexpr int kSteps = 36, kRows = 8, kLidRows = 4;
  PolygonMesh mesh;
  std::vector<std::vector<std::int32_t>> rings;
  const bool has_pole = std::hypot(at(0, 0).x, at(0, 0).y) < 1e-9;
  const auto add = [&](const glm::dvec3& p) {
    mesh.positions.push_back(p);
    return mesh.vertex_count() - 1;
  };
  rings.push_back({add({0, 0, at(0, 0).z})});
  const auto border = [](double angle) { return 0.9 + 0.08 * std::cos(3 * angle); };
  for (int row = has_pole ? 1 : 0; row <= kRows; ++row) {
    auto& ring = rings.emplace_back();
    for (int i = 0; i < kSteps; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSteps;
      ring.push_back(add(at(angle, border(angle) * row / kRows)));
    }
  }
  const std::vector<std::int32_t> rim = rings.back();
  const glm::dvec3 top(0.05, 0.02, at(0, 0.9).z + 0.35);
  for (int row = 1; row < kLidRows; ++row) {
    const double part = static_cast<double>(row) / kLidRows;
    auto& ring = rings.emplace_back();
    for (int i = 0; i < kSteps; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSteps;
      const glm::dvec3 p = glm::mix(mesh.positions[rim[i]], top, part);
      ring.push_back(add(p + glm::dvec3(0, 0, 0.05 * std::sin(5 * part + 2 * angle))));
    }
  }
  rings.push_back({add(top)});
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    const auto vertex = [&](std::size_t ring, int i) {
      return rings[ring][static_cast<std::size_t>(i) % rings[ring].size()];
    };
    for (int i = 0; i < kSteps; ++i) {
      if (rings[r].size() == 1) {
        mesh.add_face({{vertex(r, 0), vertex(r + 1, i + 1), vertex(r + 1, i)}});
      } else if (rings[r + 1].size() == 1) {
        mesh.add_face({{vertex(r, i), vertex(r, i + 1), vertex(r + 1, 0)}});
      } else {
        mesh.add_face({{vertex(r, i), vertex(r, i + 1), vertex(r + 1, i + 1), vertex(r + 1, i)}});
      }
    }
  }
  return mesh;
}

// A box of squares whose upper side is bumpy in the shape of an L: its border turns both ways.
inline PolygonMesh box_with_bumps() {
  constexpr int kSteps = 12;
  PolygonMesh mesh;
  std::vector<std::int32_t> number((kSteps + 1) * (kSteps + 1) * 2, -1);
  const auto vertex = [&](int x, int y, int z) {
    std::int32_t& v = number[static_cast<std::size_t>((z * (kSteps + 1) + y) * (kSteps + 1) + x)];
    if (v < 0) {
      v = mesh.vertex_count();
      const bool is_raised = z == 1 && x >= 3 && x <= 9 && y >= 3 && y <= 9 && (x <= 5 || y <= 5);
      const double height = is_raised ? 0.4 + 0.1 * std::sin(2.0 * x) * std::cos(1.5 * y) : 0;
      mesh.positions.emplace_back(x, y, 4 * z + height);
    }
    return v;
  };
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      mesh.add_face(
          {{vertex(i, j, 0), vertex(i, j + 1, 0), vertex(i + 1, j + 1, 0), vertex(i + 1, j, 0)}});
      mesh.add_face(
          {{vertex(i, j, 1), vertex(i + 1, j, 1), vertex(i + 1, j + 1, 1), vertex(i, j + 1, 1)}});
    }
    const auto wall = [&](int x0, int y0, int x1, int y1) {
      mesh.add_face({{vertex(x0, y0, 0), vertex(x1, y1, 0), vertex(x1, y1, 1), vertex(x0, y0, 1)}});
    };
    wall(i, 0, i + 1, 0);
    wall(kSteps, i, kSteps, i + 1);
    wall(i + 1, kSteps, i, kSteps);
    wall(0, i + 1, 0, i);
  }
  return mesh;
}

inline std::vector<MixedShape> mixed_shapes() {
  const auto around = [](double angle, double radius, double z) {
    return glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  return {{"cylinder",
           lidded([&](double a, double t) { return around(a, 1, 2 * t); }),
           {1, 1, 0, 0, 0}},
          {"cone",
           lidded([&](double a, double t) { return around(a, 2 - t, 3 * t); }),
           {1, 0, 1, 0, 0}},
          {"sphere",
           lidded([&](double a, double t) { return around(a, std::sin(2 * t), -std::cos(2 * t)); }),
           {0, 0, 0, 1, 0}},
          {"torus",
           lidded([&](double a, double t) {
             return around(a, 1 + 0.5 * std::sin(2.5 * t), -0.5 * std::cos(2.5 * t));
           }),
           {1, 0, 0, 0, 1}},
          {"box with bumps", box_with_bumps(), {6, 0, 0, 0, 0}}};
}

}  // namespace planish::test
