#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "make_scenes/mesh_builder.h"
#include "make_scenes/shapes.h"

namespace planish::shapes {

namespace {

// Outlines in quarters: both a square and a circle start at the corner direction (-1, -1) and run
// counter-clockwise, so that equal indices lie opposite each other.
glm::dvec3 square_point(std::int32_t index, std::int32_t side_count, double half_side) {
  const std::int32_t side = index / side_count;
  const double along = -half_side + 2.0 * half_side * (index % side_count) / side_count;
  switch (side % 4) {
    case 0:
      return {along, -half_side, 0.0};
    case 1:
      return {half_side, along, 0.0};
    case 2:
      return {-along, half_side, 0.0};
    default:
      return {-half_side, -along, 0.0};
  }
}

glm::dvec3 circle_point(std::int32_t index, std::int32_t side_count, double radius) {
  const double angle =
      2.0 * std::numbers::pi * index / (4.0 * side_count) - 0.75 * std::numbers::pi;
  return {radius * std::cos(angle), radius * std::sin(angle), 0.0};
}

}  // namespace

PolygonMesh open_grid(std::int32_t columns, std::int32_t rows) {
  if (columns < 1 || rows < 1) {
    throw std::invalid_argument("open_grid: at least one column and one row");
  }
  PolygonMesh mesh;
  for (std::int32_t y = 0; y <= rows; ++y) {
    for (std::int32_t x = 0; x <= columns; ++x) {
      mesh.positions.emplace_back(static_cast<double>(x) / columns,
                                  static_cast<double>(y) / columns, 0.0);
    }
  }
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < columns; ++x) {
      const std::int32_t a = y * (columns + 1) + x;
      add_face(mesh, {a, a + 1, a + columns + 2, a + columns + 1});
    }
  }
  return mesh;
}

PolygonMesh wavy_patch(std::int32_t columns, std::int32_t rows) {
  constexpr double kHeight = 0.1;
  PolygonMesh mesh = open_grid(columns, rows);
  for (glm::dvec3& p : mesh.positions) {
    p.z = kHeight * std::sin(2.0 * std::numbers::pi * p.x) * std::cos(2.0 * std::numbers::pi * p.y);
  }
  return mesh;
}

PolygonMesh plate_with_holes() {
  constexpr std::int32_t kSide = 8;   // quads along a tile's side
  constexpr std::int32_t kRings = 4;  // quads between a hole and its tile's border
  constexpr double kHoleRadius = 0.5;
  constexpr std::array<std::array<bool, 3>, 2> kHasHole{{{true, false, true}, {true, true, false}}};
  PolygonMesh mesh;
  LatticeVertices vertices(mesh);
  // Lattice points on borders are shared by tiles; the third number keeps hole vertices apart.
  const auto border_vertex = [&](std::int32_t column, std::int32_t row, const glm::dvec3& local) {
    const std::int32_t x = static_cast<std::int32_t>(std::lround((local.x + 1.0) * kSide / 2.0));
    const std::int32_t y = static_cast<std::int32_t>(std::lround((local.y + 1.0) * kSide / 2.0));
    return vertices.at({column * kSide + x, row * kSide + y, 0},
                       local + glm::dvec3(2.0 * column, 2.0 * row, 0.0));
  };
  const auto ring_vertex = [&](std::int32_t column, std::int32_t row, std::int32_t index,
                               std::int32_t ring) {
    index %= 4 * kSide;
    const glm::dvec3 outer = square_point(index, kSide, 1.0);
    if (ring == kRings) return border_vertex(column, row, outer);
    const glm::dvec3 inner = circle_point(index, kSide, kHoleRadius);
    const glm::dvec3 local = inner + (outer - inner) * (static_cast<double>(ring) / kRings);
    return vertices.at({column * 4 * kSide + index, row * kRings + ring, 1},
                       local + glm::dvec3(2.0 * column, 2.0 * row, 0.0));
  };
  const auto grid_vertex = [&](std::int32_t column, std::int32_t row, std::int32_t x,
                               std::int32_t y) {
    return border_vertex(column, row, {2.0 * x / kSide - 1.0, 2.0 * y / kSide - 1.0, 0.0});
  };
  for (std::int32_t row = 0; row < 2; ++row) {
    for (std::int32_t column = 0; column < 3; ++column) {
      const bool has_hole = kHasHole[row][column];
      for (std::int32_t i = 0; i < (has_hole ? 4 * kSide : kSide); ++i) {
        for (std::int32_t j = 0; j < (has_hole ? kRings : kSide); ++j) {
          if (has_hole) {
            add_face(mesh,
                     {ring_vertex(column, row, i, j), ring_vertex(column, row, i, j + 1),
                      ring_vertex(column, row, i + 1, j + 1), ring_vertex(column, row, i + 1, j)});
          } else {
            add_face(mesh,
                     {grid_vertex(column, row, i, j), grid_vertex(column, row, i + 1, j),
                      grid_vertex(column, row, i + 1, j + 1), grid_vertex(column, row, i, j + 1)});
          }
        }
      }
    }
  }
  return mesh;
}

PolygonMesh bearing_block() {
  constexpr std::int32_t kSide = 16;
  constexpr std::int32_t kAround = 4 * kSide;
  constexpr float kSemiSharp = 3.0f;
  // The section, outward first: each stop is an outline (a square where `is_square`) and a height,
  // reached from the one before in `steps` rows of quads. It closes on itself.
  struct Stop {
    bool is_square;
    double size, height;
    std::int32_t steps;
  };
  constexpr std::array<Stop, 6> kStops{{{false, 0.45, 0.0, 12},
                                        {true, 1.0, 0.0, 8},
                                        {true, 1.0, 0.35, 4},
                                        {false, 0.7, 0.35, 4},
                                        {false, 0.7, 1.1, 8},
                                        {false, 0.45, 1.1, 4}}};
  const auto outline = [](const Stop& stop, std::int32_t i) {
    return (stop.is_square ? square_point(i, kSide, stop.size)
                           : circle_point(i, kSide, stop.size)) +
           glm::dvec3(0.0, 0.0, stop.height);
  };
  PolygonMesh mesh;
  for (std::size_t s = 0; s < kStops.size(); ++s) {
    const Stop& from = kStops[s];
    const Stop& to = kStops[(s + 1) % kStops.size()];
    for (std::int32_t step = 0; step < to.steps; ++step) {
      const double t = static_cast<double>(step) / to.steps;
      for (std::int32_t i = 0; i < kAround; ++i) {
        mesh.positions.push_back(outline(from, i) * (1.0 - t) + outline(to, i) * t);
      }
    }
  }
  const std::int32_t ring_count = mesh.vertex_count() / kAround;
  for (std::int32_t ring = 0; ring < ring_count; ++ring) {
    const std::int32_t here = ring * kAround;
    const std::int32_t next = (ring + 1) % ring_count * kAround;
    for (std::int32_t i = 0; i < kAround; ++i) {
      const std::int32_t right = (i + 1) % kAround;
      add_face(mesh, {here + i, here + right, next + right, next + i});
    }
  }
  crease_sharp_edges(mesh, 30.0);
  for (CreaseEdge& crease : mesh.creases) {
    const bool is_upright = (crease.v1 - crease.v0) % kAround == 0;
    if (is_upright) crease.sharpness = kSemiSharp;
  }
  return mesh;
}

}  // namespace planish::shapes
