#pragma once

#include <atomic>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

#include "planish/core/work.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// Faces over `vertex_count` vertices on the moment curve, so that no two coincide.
inline PolygonMesh mesh_of(std::int32_t vertex_count,
                           std::initializer_list<std::vector<std::int32_t>> faces) {
  PolygonMesh mesh;
  for (std::int32_t i = 0; i < vertex_count; ++i)
    mesh.positions.emplace_back(i, i * i, double(i) * i * i);
  for (const auto& face : faces) mesh.add_face(face);
  return mesh;
}

inline PolygonMesh tetrahedron() {
  return mesh_of(4, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
}

inline PolygonMesh cube() {
  PolygonMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  for (const std::vector<std::int32_t>& face : {std::vector<std::int32_t>{0, 2, 3, 1},
                                                {4, 5, 7, 6},
                                                {0, 1, 5, 4},
                                                {2, 6, 7, 3},
                                                {0, 4, 6, 2},
                                                {1, 3, 7, 5}})
    mesh.add_face(face);
  return mesh;
}

/// One face, whose corners but the first are all at the origin.
inline PolygonMesh polygon(std::int32_t corners) {
  PolygonMesh mesh;
  mesh.positions.resize(corners, glm::dvec3(0.0));
  mesh.positions[0].x = 1;
  std::vector<std::int32_t> face(corners);
  for (std::int32_t i = 0; i < corners; ++i) face[i] = i;
  mesh.add_face(face);
  return mesh;
}

/// An open grid of columns x rows quads in the plane z = 0.
inline PolygonMesh grid(std::int32_t columns, std::int32_t rows) {
  PolygonMesh mesh;
  for (std::int32_t y = 0; y <= rows; ++y)
    for (std::int32_t x = 0; x <= columns; ++x) mesh.positions.emplace_back(x, y, 0);
  const auto at = [&](std::int32_t x, std::int32_t y) { return y * (columns + 1) + x; };
  for (std::int32_t y = 0; y < rows; ++y)
    for (std::int32_t x = 0; x < columns; ++x)
      mesh.add_face(std::vector{at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
  return mesh;
}

/// A closed grid of genus 1; the positions lie in the plane of the parameters.
inline PolygonMesh torus(std::int32_t columns, std::int32_t rows) {
  PolygonMesh mesh;
  for (std::int32_t y = 0; y < rows; ++y)
    for (std::int32_t x = 0; x < columns; ++x) mesh.positions.emplace_back(x, y, 0);
  const auto at = [&](std::int32_t x, std::int32_t y) {
    return (y % rows) * columns + x % columns;
  };
  for (std::int32_t y = 0; y < rows; ++y)
    for (std::int32_t x = 0; x < columns; ++x)
      mesh.add_face(std::vector{at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)});
  return mesh;
}

/// How many pairs `work` looks at, for each of `count`.
template <class Action>
double pairs_asked(std::size_t count, const Action& work) {
  const std::atomic<std::int64_t>& pairs = work_counts[static_cast<std::size_t>(Work::Pairs)];
  const std::int64_t before = pairs;
  work();
  return static_cast<double>(pairs - before) / static_cast<double>(count);
}

}  // namespace planish::test
