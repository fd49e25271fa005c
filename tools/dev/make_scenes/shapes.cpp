#include "make_scenes/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <numbers>
#include <stdexcept>
#include <unordered_map>
#include <utility>
#include <vector>

#include "make_scenes/sample_points.h"
#include "planish/core/portable_math.h"
#include "planish/files/shared/attributes.h"

namespace planish::shapes {
namespace {

constexpr double kCoordinateSteps = 1e6;        // per unit: six decimals in the file
constexpr std::int32_t kLatticeBias = 1 << 20;  // lattice points run from -2^20 to 2^20 - 1

}  // namespace

void add_face(PolygonMesh& mesh, std::initializer_list<std::int32_t> vertices) {
  mesh.add_face(std::span(vertices.begin(), vertices.size()));
}

std::int32_t LatticeVertices::at(const std::array<std::int32_t, 3>& point,
                                 const glm::dvec3& position) {
  std::uint64_t key = 0;
  for (const std::int32_t coordinate : point) {
    key = (key << 21) | static_cast<std::uint64_t>(coordinate + kLatticeBias);
  }
  const auto [entry, is_new] = vertices_.try_emplace(key, mesh_.vertex_count());
  if (is_new) mesh_.positions.push_back(position);
  return entry->second;
}

std::uint64_t edge_key(std::int32_t a, std::int32_t b) {
  const auto [low, high] = std::minmax(a, b);
  return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint32_t>(high);
}

glm::dvec3 face_normal(const PolygonMesh& mesh, std::int32_t face) {
  const auto corners = mesh.face(face);
  glm::dvec3 normal(0.0);
  const glm::dvec3 origin = mesh.positions[corners[0]];
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    normal +=
        glm::cross(mesh.positions[corners[i]] - origin, mesh.positions[corners[i + 1]] - origin);
  }
  return normal;
}

void crease_sharp_edges(PolygonMesh& mesh, double degrees) {
  const double least_cosine = portable::cos(degrees * portable::acos(-1.0) / 180.0);
  std::unordered_map<std::uint64_t, std::int32_t> first_face;
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    const auto corners = mesh.face(face);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t v0 = corners[i];
      const std::int32_t v1 = corners[(i + 1) % corners.size()];
      const auto [entry, is_new] = first_face.try_emplace(edge_key(v0, v1), face);
      if (is_new) continue;
      const glm::dvec3 here = glm::normalize(face_normal(mesh, face));
      const glm::dvec3 there = glm::normalize(face_normal(mesh, entry->second));
      if (glm::dot(here, there) < least_cosine) mesh.creases.push_back({v0, v1});
    }
  }
}

double rounded(double number) {
  // Adding zero turns -0 into 0, which would else show in the file.
  return std::round(number * kCoordinateSteps) / kCoordinateSteps + 0.0;
}

void round_positions(PolygonMesh& mesh) {
  for (glm::dvec3& position : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = rounded(position[axis]);
    }
  }
  for (glm::dvec2& uv : mesh.uvs) uv = {rounded(uv.x), rounded(uv.y)};
}

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

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::int32_t kHighestLevel = 11;  // 84 M triangles; the next would pass 2^27 vertices

PolygonMesh icosahedron() {
  const double golden = std::numbers::phi;
  PolygonMesh mesh;
  for (const double one : {-1.0, 1.0}) {
    for (const double ratio : {-golden, golden}) {
      mesh.positions.emplace_back(0.0, one, ratio);
      mesh.positions.emplace_back(one, ratio, 0.0);
      mesh.positions.emplace_back(ratio, 0.0, one);
    }
  }
  // Triangles are the triples at the edge length 2, turned outward.
  const auto is_edge = [&](std::int32_t a, std::int32_t b) {
    return std::abs(glm::distance(mesh.positions[a], mesh.positions[b]) - 2.0) < 1e-9;
  };
  for (std::int32_t a = 0; a < 12; ++a) {
    for (std::int32_t b = a + 1; b < 12; ++b) {
      for (std::int32_t c = b + 1; c < 12; ++c) {
        if (!is_edge(a, b) || !is_edge(b, c) || !is_edge(c, a)) continue;
        const glm::dvec3& p = mesh.positions[a];
        const glm::dvec3 normal = glm::cross(mesh.positions[b] - p, mesh.positions[c] - p);
        if (glm::dot(normal, p) > 0.0) {
          add_face(mesh, {a, b, c});
        } else {
          add_face(mesh, {a, c, b});
        }
      }
    }
  }
  for (glm::dvec3& position : mesh.positions) position = glm::normalize(position);
  return mesh;
}

PolygonMesh split_on_sphere(const PolygonMesh& coarse) {
  PolygonMesh fine;
  fine.positions = coarse.positions;
  std::unordered_map<std::uint64_t, std::int32_t> midpoints;
  const auto midpoint = [&](std::int32_t a, std::int32_t b) {
    const auto [entry, is_new] = midpoints.try_emplace(edge_key(a, b), fine.vertex_count());
    if (is_new) {
      fine.positions.push_back(glm::normalize(fine.positions[a] + fine.positions[b]));
    }
    return entry->second;
  };
  for (std::int32_t face = 0; face < coarse.face_count(); ++face) {
    const auto corners = coarse.face(face);
    const std::int32_t ab = midpoint(corners[0], corners[1]);
    const std::int32_t bc = midpoint(corners[1], corners[2]);
    const std::int32_t ca = midpoint(corners[2], corners[0]);
    add_face(fine, {corners[0], ab, ca});
    add_face(fine, {corners[1], bc, ab});
    add_face(fine, {corners[2], ca, bc});
    add_face(fine, {ab, bc, ca});
  }
  return fine;
}

}  // namespace

PolygonMesh torus(const TorusOptions& options) {
  if (options.ring_count < 3 || options.tube_count < 3) {
    throw std::invalid_argument("torus: both counts must be at least 3");
  }
  PolygonMesh mesh;
  const std::int32_t rings = options.ring_count;
  const std::int32_t tubes = options.tube_count;
  mesh.positions.reserve(static_cast<std::size_t>(rings) * tubes);
  for (std::int32_t i = 0; i < rings; ++i) {
    const double along = kTurn * i / rings;
    for (std::int32_t j = 0; j < tubes; ++j) {
      const double around = kTurn * j / tubes;
      const double distance = options.radius + options.tube_radius * portable::cos(around);
      mesh.positions.emplace_back(distance * portable::cos(along), distance * portable::sin(along),
                                  options.tube_radius * portable::sin(around));
    }
  }
  mesh.face_vertices.reserve(static_cast<std::size_t>(rings) * tubes * 4);
  mesh.face_offsets.reserve(static_cast<std::size_t>(rings) * tubes + 1);
  for (std::int32_t i = 0; i < rings; ++i) {
    const std::int32_t here = i * tubes;
    const std::int32_t next = (i + 1) % rings * tubes;
    for (std::int32_t j = 0; j < tubes; ++j) {
      const std::int32_t up = (j + 1) % tubes;
      add_face(mesh, {here + j, next + j, next + up, here + up});
    }
  }
  return mesh;
}

PolygonMesh icosphere(std::int32_t level) {
  if (level < 0 || level > kHighestLevel) {
    throw std::invalid_argument("icosphere: level must be 0 to 11");
  }
  PolygonMesh mesh = icosahedron();
  for (std::int32_t i = 0; i < level; ++i) mesh = split_on_sphere(mesh);
  return mesh;
}

PolygonMesh pole_sphere(std::int32_t segment_count, std::int32_t ring_count) {
  if (segment_count < 3 || ring_count < 1) {
    throw std::invalid_argument("pole_sphere: at least 3 segments and 1 ring");
  }
  PolygonMesh mesh;
  // ring_count + 1 circles evenly between the poles, from the south.
  for (std::int32_t ring = 0; ring <= ring_count; ++ring) {
    const double latitude = std::numbers::pi * (ring + 1) / (ring_count + 2);
    for (std::int32_t i = 0; i < segment_count; ++i) {
      const double longitude = kTurn * i / segment_count;
      mesh.positions.emplace_back(portable::sin(latitude) * portable::cos(longitude),
                                  portable::sin(latitude) * portable::sin(longitude),
                                  -portable::cos(latitude));
    }
  }
  const std::int32_t pole = mesh.vertex_count();
  mesh.positions.emplace_back(0.0, 0.0, 1.0);
  std::vector<std::int32_t> cap;
  for (std::int32_t i = segment_count - 1; i >= 0; --i) cap.push_back(i);
  mesh.add_face(cap);
  for (std::int32_t ring = 0; ring <= ring_count; ++ring) {
    for (std::int32_t i = 0; i < segment_count; ++i) {
      const std::int32_t a = ring * segment_count + i;
      const std::int32_t b = ring * segment_count + (i + 1) % segment_count;
      if (ring < ring_count) {
        add_face(mesh, {a, b, b + segment_count, a + segment_count});
      } else {
        add_face(mesh, {a, b, pole});
      }
    }
  }
  return mesh;
}

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
  return {radius * portable::cos(angle), radius * portable::sin(angle), 0.0};
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
    p.z = kHeight * portable::sin(2.0 * std::numbers::pi * p.x) *
          portable::cos(2.0 * std::numbers::pi * p.y);
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

namespace {

// Shapes that carry texture coordinates, colours, groups and holes.

constexpr int kChartColumns = 3;
constexpr double kChartMargin = 0.05;  // of a chart's cell, so that no two charts touch

// Gives equal texture coordinates one index, in the order of their first use. The charts keep
// apart, so that no two of them share any.
void share_equal_uvs(PolygonMesh& mesh) {
  std::map<std::pair<double, double>, std::int32_t> indices;
  std::vector<glm::dvec2> uvs;
  for (std::int32_t& index : mesh.face_uvs) {
    const glm::dvec2 uv = mesh.uvs[index];
    const auto [entry, is_new] =
        indices.try_emplace({uv.x, uv.y}, static_cast<std::int32_t>(uvs.size()));
    if (is_new) uvs.push_back(uv);
    index = entry->second;
  }
  mesh.uvs = std::move(uvs);
}

int side_of(const glm::dvec3& normal) {
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  }
  return 2 * axis + (normal[axis] > 0 ? 1 : 0);
}

// Seen from outside, u runs to the right and v upwards.
glm::dvec2 chart_point(int side, const glm::dvec3& p) {
  const int axis = side / 2;
  const double right = side % 2 == 1 ? p[(axis + 1) % 3] : -p[(axis + 1) % 3];
  const glm::dvec2 inside =
      kChartMargin + (1 - 2 * kChartMargin) * (glm::dvec2(right, p[(axis + 2) % 3]) + 1.0) / 2.0;
  const int row = side / kChartColumns, column = side % kChartColumns;
  return {(column + inside.x) / kChartColumns, (row + inside.y) / 2};
}

}  // namespace

PolygonMesh mapped_cube(std::int32_t cells) {
  PolygonMesh mesh = cube(cells);
  mesh.groups = {{"walls", "plaster"}, {"lids", "brass"}};
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    const int side = side_of(face_normal(mesh, face));
    mesh.face_groups.push_back(side / 2 == 2 ? 1 : 0);
    for (const std::int32_t v : mesh.face(face)) {
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
      mesh.uvs.push_back(chart_point(side, mesh.positions[v]));
    }
  }
  share_equal_uvs(mesh);
  for (const glm::dvec3& p : mesh.positions)
    mesh.colors.push_back(linear_of_srgb(glm::dvec4((p + 1.0) / 2.0, 1.0)));
  return mesh;
}

PolygonMesh cube_with_windows() {
  constexpr std::int32_t kCells = 3;
  PolygonMesh mesh = cube(kCells);
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    // The middle one of each side: no corner of it lies on an edge of the cube.
    bool is_window = true;
    for (const std::int32_t v : mesh.face(face)) {
      const glm::dvec3 p = glm::abs(mesh.positions[v]);
      is_window = is_window && p.x + p.y + p.z < 1.8;
    }
    if (is_window) mesh.hole_faces.push_back(face);
  }
  return mesh;
}

namespace {

using Polygon = std::vector<std::int32_t>;

std::vector<Polygon> polygons_of(const PolygonMesh& mesh) {
  std::vector<Polygon> polygons;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    polygons.emplace_back(mesh.face(f).begin(), mesh.face(f).end());
  }
  return polygons;
}

struct FacePair {
  std::int32_t v0, v1;         // the edge, in the direction of the first face
  std::int32_t first, second;  // faces
};

std::vector<FacePair> face_pairs_of(const PolygonMesh& mesh) {
  std::vector<FacePair> pairs;
  std::unordered_map<std::uint64_t, std::size_t> pair_at;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t v0 = corners[i];
      const std::int32_t v1 = corners[(i + 1) % corners.size()];
      const auto [entry, is_new] = pair_at.try_emplace(edge_key(v0, v1), pairs.size());
      if (is_new) {
        pairs.push_back({v0, v1, f, f});
      } else {
        pairs[entry->second].second = f;
      }
    }
  }
  return pairs;
}

template <typename T>
void shuffle(std::vector<T>& items, RandomNumbers& random) {
  for (std::size_t i = items.size(); i > 1; --i) {
    std::swap(items[i - 1], items[random.below(static_cast<std::int32_t>(i))]);
  }
}

// The face of both polygons without the edge v0 -> v1 of `first`.
Polygon merged(const Polygon& first, const Polygon& second, std::int32_t v0, std::int32_t v1) {
  Polygon result = first;
  std::rotate(result.begin(), std::find(result.begin(), result.end(), v1), result.end());
  Polygon other = second;  // runs v1 -> v0
  std::rotate(other.begin(), std::find(other.begin(), other.end(), v0), other.end());
  result.insert(result.end(), other.begin() + 1, other.end() - 1);
  return result;
}

std::int32_t shared_vertex_count(const Polygon& a, const Polygon& b) {
  return static_cast<std::int32_t>(std::count_if(a.begin(), a.end(), [&](std::int32_t v) {
    return std::find(b.begin(), b.end(), v) != b.end();
  }));
}

std::int32_t root_of(std::vector<std::int32_t>& parents, std::int32_t face) {
  while (parents[face] != face) face = parents[face] = parents[parents[face]];
  return face;
}

// Two triangles (a, b, c) and (b, a, d) become (c, d, b) and (d, c, a).
void flip_edges(std::vector<Polygon>& faces, std::vector<std::int32_t>& valences,
                std::int32_t flip_count, RandomNumbers& random) {
  constexpr std::int32_t kLeastValence = 3;
  constexpr std::int32_t kGreatestValence = 12;
  std::unordered_map<std::uint64_t, std::int32_t> face_at;  // by directed edge
  const auto directed = [](std::int32_t a, std::int32_t b) {
    return (static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint32_t>(b);
  };
  const auto enter = [&](std::int32_t face, Polygon corners) {
    for (int i = 0; i < 3; ++i) face_at[directed(corners[i], corners[(i + 1) % 3])] = face;
    faces[face] = std::move(corners);
  };
  for (std::size_t f = 0; f < faces.size(); ++f) enter(static_cast<std::int32_t>(f), faces[f]);
  for (std::int32_t i = 0; i < flip_count; ++i) {
    const std::int32_t face = random.below(static_cast<std::int32_t>(faces.size()));
    const std::int32_t corner = random.below(3);
    const std::int32_t a = faces[face][corner];
    const std::int32_t b = faces[face][(corner + 1) % 3];
    const std::int32_t c = faces[face][(corner + 2) % 3];
    const std::int32_t other = face_at.at(directed(b, a));
    std::int32_t d = 0;
    for (const std::int32_t v : faces[other]) {
      if (v != a && v != b) d = v;
    }
    if (face_at.contains(directed(c, d)) || face_at.contains(directed(d, c))) continue;
    if (valences[a] <= kLeastValence || valences[b] <= kLeastValence) continue;
    if (valences[c] >= kGreatestValence || valences[d] >= kGreatestValence) continue;
    face_at.erase(directed(a, b));
    face_at.erase(directed(b, a));
    enter(face, {c, d, b});
    enter(other, {d, c, a});
    --valences[a], --valences[b], ++valences[c], ++valences[d];
  }
}

// Moves every vertex to the mean of its neighbours on the unit sphere, many times: an embedding
// without overlaps.
void smooth_on_sphere(PolygonMesh& mesh) {
  constexpr int kSteps = 300;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const glm::dvec3 normal = face_normal(mesh, f);
      glm::dvec3 centroid(0.0);
      for (const std::int32_t v : mesh.face(f)) centroid += mesh.positions[v] / 3.0;
      // Weights by area keep the mesh from gathering on one side.
      for (const std::int32_t v : mesh.face(f)) sums[v] += centroid * glm::length(normal);
    }
    for (std::size_t v = 0; v < sums.size(); ++v) mesh.positions[v] = glm::normalize(sums[v]);
  }
}

// Evens out a mesh of three edges at every vertex: each vertex towards the mean of its neighbours.
void smooth_dual(PolygonMesh& mesh) {
  constexpr int kSteps = 40;
  for (int step = 0; step < kSteps; ++step) {
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto corners = mesh.face(f);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        sums[corners[i]] += mesh.positions[corners[(i + 1) % corners.size()]];
      }
    }
    for (std::size_t v = 0; v < sums.size(); ++v) {
      mesh.positions[v] = glm::normalize(mesh.positions[v] + sums[v] / 3.0);
    }
  }
}

}  // namespace

PolygonMesh dual(const PolygonMesh& mesh) {
  PolygonMesh result;
  std::vector<std::unordered_map<std::int32_t, std::pair<std::int32_t, std::int32_t>>> around(
      mesh.positions.size());  // by incoming neighbour: face and outgoing neighbour
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      sum += mesh.positions[corners[i]];
      const std::int32_t previous = corners[(i + corners.size() - 1) % corners.size()];
      around[corners[i]][corners[(i + 1) % corners.size()]] = {f, previous};
    }
    result.positions.push_back(sum / static_cast<double>(corners.size()));
  }
  for (std::size_t v = 0; v < around.size(); ++v) {
    if (around[v].empty()) continue;
    std::int32_t first = around[v].begin()->first;
    for (const auto& [neighbour, unused] : around[v]) first = std::min(first, neighbour);
    Polygon polygon;
    std::int32_t neighbour = first;
    do {
      const auto [face, next] = around[v].at(neighbour);
      polygon.push_back(face);
      neighbour = next;
    } while (neighbour != first);
    result.add_face(polygon);
  }
  return result;
}

PolygonMesh random_polygon_mesh(const RandomMeshOptions& options) {
  RandomNumbers random(options.seed);
  const PolygonMesh sphere = icosphere(options.level);
  std::vector<Polygon> faces = polygons_of(sphere);
  std::vector<FacePair> pairs = face_pairs_of(sphere);
  std::vector<std::int32_t> valences(sphere.positions.size(), 0);
  for (const FacePair& pair : pairs) ++valences[pair.v0], ++valences[pair.v1];
  std::vector<std::int32_t> parents(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) parents[f] = static_cast<std::int32_t>(f);
  shuffle(pairs, random);
  pairs.resize(static_cast<std::size_t>(options.merged_share * pairs.size()));
  for (const FacePair& pair : pairs) {
    const std::int32_t first = root_of(parents, pair.first);
    const std::int32_t second = root_of(parents, pair.second);
    if (first == second) continue;
    // Faces that meet elsewhere too would leave a vertex of valence 2 or a hole.
    if (shared_vertex_count(faces[first], faces[second]) != 2) continue;
    if (valences[pair.v0] <= 3 || valences[pair.v1] <= 3) continue;
    Polygon face = merged(faces[first], faces[second], pair.v0, pair.v1);
    if (static_cast<std::int32_t>(face.size()) > options.largest_face) continue;
    faces[first] = std::move(face);
    parents[second] = first;
    --valences[pair.v0], --valences[pair.v1];
  }
  PolygonMesh mesh;
  mesh.positions = sphere.positions;
  const double edge =
      glm::distance(sphere.positions[sphere.face(0)[0]], sphere.positions[sphere.face(0)[1]]);
  for (glm::dvec3& position : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] += options.jitter * edge * (2.0 * random.unit() - 1.0);
    }
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (parents[f] == static_cast<std::int32_t>(f)) mesh.add_face(faces[f]);
  }
  return mesh;
}

PolygonMesh mixed_polygons(std::uint32_t seed) {
  constexpr std::int32_t kLevel = 3;
  constexpr std::int32_t kFlipsPerFace = 1;
  const glm::dvec3 kAxes(1.0, 0.8, 0.6);
  RandomNumbers random(seed);
  PolygonMesh sphere = icosphere(kLevel);
  std::vector<Polygon> faces = polygons_of(sphere);
  std::vector<std::int32_t> valences(sphere.positions.size(), 0);
  for (const std::int32_t v : sphere.face_vertices) ++valences[v];
  flip_edges(faces, valences, kFlipsPerFace * sphere.face_count(), random);
  sphere.face_vertices.clear();
  sphere.face_offsets = {0};
  for (const Polygon& face : faces) sphere.add_face(face);
  smooth_on_sphere(sphere);
  PolygonMesh mesh = dual(sphere);
  smooth_dual(mesh);
  for (glm::dvec3& position : mesh.positions) position *= kAxes;
  return mesh;
}

}  // namespace planish::shapes
