#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/backend.h"
#include "planish/solve/stencil_table.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::testing {

/// Limit masks of a torus of width x height quads: the tensor product of (1 6 1)/8.
inline StencilTable torus_masks(std::int32_t width, std::int32_t height) {
  constexpr double kCurve[3] = {1 / 8.0, 6 / 8.0, 1 / 8.0};
  StencilTable rows;
  for (std::int32_t y = 0; y < height; ++y)
    for (std::int32_t x = 0; x < width; ++x) {
      rows.sizes.push_back(9);
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
          rows.indices.push_back((y + j + height) % height * width + (x + i + width) % width);
          rows.weights.push_back(kCurve[i + 1] * kCurve[j + 1]);
        }
    }
  rows.close(width * height);
  return rows;
}

/// Rows of 0 to 12 entries anywhere among `source_count` points, weights in [-1, 1] that keep a
/// solve bounded.
inline StencilTable random_table(std::int32_t row_count, std::int32_t source_count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> weight(-1, 1);
  StencilTable rows;
  for (std::int32_t row = 0; row < row_count; ++row) {
    const auto size = static_cast<std::int32_t>(random() % 13);
    rows.sizes.push_back(size);
    for (std::int32_t k = 0; k < size; ++k) {
      rows.indices.push_back(static_cast<std::int32_t>(random() % source_count));
      rows.weights.push_back(weight(random) / 6);
    }
  }
  rows.close(source_count);
  return rows;
}

inline std::vector<glm::dvec3> random_points(std::int32_t count) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(-0.01, 0.01);
  std::vector<glm::dvec3> points(count);
  for (glm::dvec3& point : points)
    point = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

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

/// Random meshes, four times: closed, with creases, open with creases, and that with holes.
[[nodiscard]] inline std::vector<test::NamedMesh> random_kinds() {
  std::vector<test::NamedMesh> meshes;
  for (std::uint32_t seed = 1; seed < 5; ++seed) {
    const std::string name = std::to_string(seed);
    meshes.push_back({"closed " + name, test::random_closed_mesh(seed)});
    meshes.push_back(
        {"creases " + name, test::with_random_creases(test::random_closed_mesh(seed), 0.2, seed)});
    meshes.push_back(
        {"open " + name, test::with_random_creases(test::random_open_mesh(seed), 0.1, seed)});
    PolygonMesh holed = meshes.back().mesh;
    holed.hole_faces = {2, 5, holed.face_count() - 1};
    meshes.push_back({"holes " + name, holed});
  }
  return meshes;
}

/// With further vertices in front of vertex `at`, which no face names.
[[nodiscard]] inline PolygonMesh with_unused(PolygonMesh mesh, std::int32_t at,
                                             const glm::dvec3& where, std::int32_t count = 1) {
  mesh.positions.insert(mesh.positions.begin() + at, static_cast<std::size_t>(count), where);
  const auto move = [&](std::int32_t& v) { v += v >= at ? count : 0; };
  for (std::int32_t& v : mesh.face_vertices) move(v);
  for (CreaseEdge& crease : mesh.creases) move(crease.v0), move(crease.v1);
  return mesh;
}

/// As a device is given them. (GCC 12 at -O2 leaves out a conversion to float and back that does
/// not pass through memory.)
[[nodiscard]] inline std::vector<glm::dvec3> through_floats(const std::vector<glm::dvec3>& points) {
  const std::vector<glm::vec3> floats(points.begin(), points.end());
  return {floats.begin(), floats.end()};
}

/// The mesh with its vertices where the surface that it is the cage of has them: what a System has
/// to be given for that surface.
[[nodiscard]] inline PolygonMesh on_surface(PolygonMesh cage) {
  PolygonMesh whole = cage;
  whole.hole_faces.clear();  // their vertices have no rows
  const SurfaceMesh surface = evaluate(whole, *make_cpu_backend(), {.level = 0});
  for (std::size_t row = 0; row < surface.base_vertices.size(); ++row)
    cage.positions[surface.base_vertices[row]] = surface.positions[row];
  return cage;
}

/// Faces in charts, each with an affine map of its own from space to the texture; every other one
/// is turned over.
[[nodiscard]] inline PolygonMesh with_charts(PolygonMesh mesh, std::int32_t charts,
                                             std::uint32_t seed) {
  mesh.positions = through_floats(mesh.positions);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<std::array<double, 8>> maps(static_cast<std::size_t>(charts));
  for (auto& map : maps)
    for (double& entry : map) entry = number(random);
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> known;
  mesh.uvs.clear();
  mesh.face_uvs.clear();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t chart = f * charts / mesh.face_count();
    const auto& m = maps[chart];
    for (const std::int32_t v : mesh.face(f)) {
      const auto [entry, is_new] =
          known.try_emplace({chart, v}, static_cast<std::int32_t>(mesh.uvs.size()));
      const glm::dvec3& p = mesh.positions[v];
      if (is_new)
        mesh.uvs.emplace_back(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
                              m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7]);
      mesh.face_uvs.push_back(entry->second);
    }
  }
  return mesh;
}

[[nodiscard]] inline std::vector<PolygonMesh> textured_meshes() {
  return {with_charts(test::torus(9, 7, 2, 0.7), 5, 1),
          with_charts(test::random_closed_mesh(3), 7, 2),
          with_charts(test::with_random_creases(test::random_open_mesh(2), 0.1, 3), 6, 3),
          with_charts(test::cube(), 6, 4), with_charts(test::prism(5), 1, 5),
          // Rings that are evaluated by their sums.
          with_charts(test::prism(40), 1, 6), with_charts(test::bipyramid(36), 3, 7)};
}

}  // namespace planish::testing
