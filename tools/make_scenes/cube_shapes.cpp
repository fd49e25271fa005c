#include <array>
#include <glm/vec3.hpp>
#include <stdexcept>

#include "make_scenes/mesh_builder.h"
#include "make_scenes/shapes.h"

namespace planish::shapes {

namespace {

// The boundary quads of a set of lattice cells; `is_solid` takes a cell, inside the block or not.
template <typename IsSolid>
PolygonMesh boundary_of_cells(std::int32_t cells, IsSolid is_solid) {
  PolygonMesh mesh;
  LatticeVertices vertices(mesh);
  const auto vertex = [&](const std::array<std::int32_t, 3>& point) {
    const glm::dvec3 corner(point[0], point[1], point[2]);
    return vertices.at(point, corner * (2.0 / cells) - 1.0);
  };
  const auto add_side = [&](const std::array<std::int32_t, 3>& cell, int axis, bool positive) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    std::array<std::int32_t, 4> corners;
    constexpr std::array<std::array<int, 2>, 4> kAround{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    for (int i = 0; i < 4; ++i) {
      std::array<std::int32_t, 3> point = cell;
      point[axis] += positive ? 1 : 0;
      point[u] += kAround[i][0];
      point[v] += kAround[i][1];
      corners[positive ? i : 3 - i] = vertex(point);
    }
    mesh.add_face(corners);
  };
  for (std::int32_t z = 0; z < cells; ++z) {
    for (std::int32_t y = 0; y < cells; ++y) {
      for (std::int32_t x = 0; x < cells; ++x) {
        const std::array<std::int32_t, 3> cell{x, y, z};
        if (!is_solid(cell)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (const bool positive : {false, true}) {
            std::array<std::int32_t, 3> next = cell;
            next[axis] += positive ? 1 : -1;
            const bool is_outside = next[axis] < 0 || next[axis] >= cells;
            if (is_outside || !is_solid(next)) add_side(cell, axis, positive);
          }
        }
      }
    }
  }
  return mesh;
}

}  // namespace

PolygonMesh cube(std::int32_t cells) {
  if (cells < 1) throw std::invalid_argument("cube: cells must be at least 1");
  return boundary_of_cells(cells, [](const auto&) { return true; });
}

PolygonMesh cube_with_tunnels(std::int32_t cells, std::int32_t hole_cells) {
  const std::int32_t margin = (cells - hole_cells) / 2;
  if (hole_cells < 1 || margin < 1 || (cells - hole_cells) % 2 != 0) {
    throw std::invalid_argument("cube_with_tunnels: cells - hole_cells must be even and positive");
  }
  return boundary_of_cells(cells, [=](const std::array<std::int32_t, 3>& cell) {
    int inside_count = 0;
    for (const std::int32_t coordinate : cell) {
      if (coordinate >= margin && coordinate < margin + hole_cells) ++inside_count;
    }
    return inside_count < 2;
  });
}

PolygonMesh l_bracket() {
  // Outline counter-clockwise in the xz plane seen from -y.
  constexpr std::array<std::array<double, 2>, 6> kOutline{
      {{0.0, 0.0}, {2.0, 0.0}, {2.0, 0.5}, {0.5, 0.5}, {0.5, 1.5}, {0.0, 1.5}}};
  constexpr double kWidth = 1.0;
  PolygonMesh mesh;
  for (const double y : {0.0, kWidth}) {
    for (const auto& [x, z] : kOutline) mesh.positions.emplace_back(x, y, z);
  }
  add_face(mesh, {0, 1, 2, 3, 4, 5});
  add_face(mesh, {11, 10, 9, 8, 7, 6});
  for (std::int32_t i = 0; i < 6; ++i) {
    const std::int32_t next = (i + 1) % 6;
    add_face(mesh, {next, i, i + 6, next + 6});
  }
  return mesh;
}

}  // namespace planish::shapes
