#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>

#include "support/meshes.h"

namespace planish::test {

using glm::dvec3;
using std::int32_t;

namespace {

// A flat grid of the cells that `keep` wants, without the vertices that none of them uses.
PolygonMesh grid_cells(int columns, int rows, const std::function<bool(int, int)>& keep) {
  std::vector<dvec3> positions;
  std::map<std::pair<int, int>, int32_t> index;
  const auto vertex = [&](int i, int j) {
    const auto [at, is_new] = index.try_emplace({i, j}, int32_t(positions.size()));
    if (is_new) positions.push_back({i, j, 0});
    return at->second;
  };
  FaceList faces;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      if (!keep(i, j)) continue;
      const int32_t a = vertex(i, j), b = vertex(i + 1, j);
      const int32_t c = vertex(i + 1, j + 1), d = vertex(i, j + 1);
      faces.push_back({a, b, c, d});
    }
  }
  return make_mesh(positions, faces);
}

}  // namespace

PolygonMesh grid(int columns, int rows, const std::function<dvec3(double, double)>& shape) {
  std::vector<dvec3> positions;
  FaceList faces;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      positions.push_back(shape(i, j));
      if (i == columns || j == rows) continue;
      const int32_t a = j * (columns + 1) + i, d = a + columns + 1;
      faces.push_back({a, a + 1, d + 1, d});
    }
  }
  return make_mesh(positions, faces);
}

PolygonMesh flat_grid(int columns, int rows) {
  return grid(columns, rows, [](double x, double y) { return dvec3(x, y, 0); });
}

PolygonMesh plate_with_hole(int n) {
  return grid_cells(n, n, [n](int i, int j) { return i < 2 || j < 2 || i >= n - 2 || j >= n - 2; });
}

PolygonMesh l_shaped_plate(int n) {
  return grid_cells(2 * n, 2 * n, [n](int i, int j) { return i < n || j < n; });
}

PolygonMesh single_polygon(int n) {
  std::vector<dvec3> positions;
  FaceList faces(1);
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    positions.push_back({std::cos(angle), std::sin(angle), 0});
    faces[0].push_back(i);
  }
  return make_mesh(positions, faces);
}

PolygonMesh open_fan(int n) {
  PolygonMesh mesh = single_polygon(n);
  FaceList faces;
  for (int i = 0; i < n; ++i) faces.push_back({i, (i + 1) % n, n});
  std::vector<dvec3> positions = mesh.positions;
  positions.push_back({0, 0, 0.3});
  return make_mesh(positions, faces);
}

int32_t vertex_at(const PolygonMesh& mesh, const dvec3& point) {
  int32_t best = 0;
  for (int32_t v = 1; v < mesh.vertex_count(); ++v) {
    if (glm::distance(mesh.positions[v], point) < glm::distance(mesh.positions[best], point)) {
      best = v;
    }
  }
  return best;
}

PolygonMesh bent_sheets() {
  PolygonMesh mesh;
  const auto line = [](int i) { return glm::dvec3(i, 0, 0.3 * std::sin(1.3 * i)); };
  for (int i = 0; i <= kBentEdges; ++i) mesh.positions.push_back(line(i));
  for (int sheet = 0; sheet < 3; ++sheet) {
    const double angle = 2 * std::numbers::pi * sheet / 3;
    const auto first = static_cast<std::int32_t>(mesh.positions.size());
    for (int i = 0; i <= kBentEdges; ++i) {
      const double width = 0.2 + 0.3 * sheet + 0.1 * (i % 3);
      mesh.positions.push_back(line(i) + width * glm::dvec3(0.1, std::cos(angle), std::sin(angle)));
    }
    for (int i = 0; i < kBentEdges; ++i)
      mesh.add_face(std::array{i, i + 1, first + i + 1, first + i});
  }
  return mesh;
}

PolygonMesh plane_and_quarter_round() {
  return grid(8, 1, [](double step, double y) {
    const double angle = std::numbers::pi / 12 * (step - 1);
    return step == 0   ? dvec3(-2, y, 1)
           : step == 8 ? dvec3(1, y, -2)
                       : dvec3(std::sin(angle), y, std::cos(angle));
  });
}

}  // namespace planish::test
