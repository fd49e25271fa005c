#include "support/meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <utility>

namespace planish::test {

using glm::dvec3;
using std::int32_t;

PolygonMesh make_mesh(std::vector<dvec3> positions, const FaceList& faces) {
  PolygonMesh mesh;
  mesh.positions = std::move(positions);
  for (const auto& face : faces) mesh.add_face(face);
  return mesh;
}

FaceList faces_of(const PolygonMesh& mesh) {
  FaceList faces;
  for (int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    faces.emplace_back(face.begin(), face.end());
  }
  return faces;
}

PolygonMesh tetrahedron() {
  return make_mesh({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
                   {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
}

PolygonMesh cube() {
  std::vector<dvec3> positions;
  for (int i = 0; i < 8; ++i) {
    positions.push_back(dvec3(i & 1, (i >> 1) & 1, (i >> 2) & 1) * 2.0 - 1.0);
  }
  return make_mesh(
      positions,
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

namespace {

// One face a vertex of `mesh`, one vertex a face: walks the half-edges around each vertex.
PolygonMesh dual(const PolygonMesh& mesh) {
  std::vector<dvec3> positions;
  std::map<std::pair<int32_t, int32_t>, int32_t> face_left_of;
  std::map<std::pair<int32_t, int32_t>, int32_t> before;  // (face, vertex) -> previous corner
  std::map<int32_t, int32_t> first_face;
  for (int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    dvec3 centre(0.0);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const int32_t v = face[i], next = face[(i + 1) % face.size()];
      centre += mesh.positions[v] / double(face.size());
      face_left_of[{v, next}] = f;
      before[{f, next}] = v;
      first_face[v] = f;
    }
    positions.push_back(centre);
  }
  FaceList faces;
  for (const auto& [vertex, start] : first_face) {
    std::vector<int32_t> ring;
    int32_t f = start;
    do {
      ring.push_back(f);
      f = face_left_of.at({vertex, before.at({f, vertex})});
    } while (f != start);
    faces.push_back(ring);
  }
  return make_mesh(positions, faces);
}

dvec3 on_circle(int i, int n, double z) {
  const double angle = 2 * std::numbers::pi * i / n;
  return {std::cos(angle), std::sin(angle), z};
}

}  // namespace

PolygonMesh dodecahedron() { return dual(icosphere(0)); }

PolygonMesh prism(int n) {
  std::vector<dvec3> positions;
  for (int i = 0; i < n; ++i) positions.push_back(on_circle(i, n, -0.5));
  for (int i = 0; i < n; ++i) positions.push_back(on_circle(i, n, 0.5));
  FaceList faces(2);
  for (int i = 0; i < n; ++i) {
    faces[0].push_back(n - 1 - i);
    faces[1].push_back(n + i);
    faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  return make_mesh(positions, faces);
}

PolygonMesh bipyramid(int n) {
  std::vector<dvec3> positions;
  for (int i = 0; i < n; ++i) positions.push_back(on_circle(i, n, 0));
  positions.push_back({0, 0, 1});
  positions.push_back({0, 0, -1});
  FaceList faces;
  for (int i = 0; i < n; ++i) {
    faces.push_back({i, (i + 1) % n, n});
    faces.push_back({(i + 1) % n, i, n + 1});
  }
  return make_mesh(positions, faces);
}

PolygonMesh chamfered_prism(int n) {
  std::vector<dvec3> positions;
  FaceList faces;
  const std::array<std::array<double, 2>, 4> profile{{{.9, 0}, {1, .1}, {1, .7}, {.9, .8}}};
  for (const auto& [radius, z] : profile)
    for (int i = 0; i < n; ++i) positions.push_back(radius * on_circle(i, n, 0) + dvec3(0, 0, z));
  std::vector<std::int32_t> bottom, top;
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    for (int ring = 0; ring < 3 * n; ring += n)
      faces.push_back({ring + i, ring + next, ring + n + next, ring + n + i});
    bottom.push_back(n - 1 - i);
    top.push_back(3 * n + i);
  }
  faces.push_back(bottom);
  faces.push_back(top);
  return make_mesh(positions, faces);
}

PolygonMesh torus(int around, int across, double major, double minor) {
  std::vector<dvec3> positions;
  FaceList faces;
  for (int i = 0; i < around; ++i) {
    const dvec3 out = on_circle(i, around, 0);
    for (int j = 0; j < across; ++j) {
      const dvec3 tube = on_circle(j, across, 0) * minor;
      positions.push_back(out * (major + tube.x) + dvec3(0, 0, tube.y));
      const int next_i = (i + 1) % around, next_j = (j + 1) % across;
      faces.push_back(
          {i * across + j, next_i * across + j, next_i * across + next_j, i * across + next_j});
    }
  }
  return make_mesh(positions, faces);
}

namespace {

PolygonMesh icosahedron() {
  std::vector<dvec3> positions{{0, 0, 1}};
  for (int ring = 0; ring < 2; ++ring) {
    for (int i = 0; i < 5; ++i) {
      const dvec3 p = on_circle(2 * i + ring, 10, ring == 0 ? 0.5 : -0.5);
      positions.push_back(glm::normalize(p));
    }
  }
  positions.push_back({0, 0, -1});
  FaceList faces;
  for (int i = 0; i < 5; ++i) {
    const int a = 1 + i, b = 1 + (i + 1) % 5, c = 6 + i, d = 6 + (i + 1) % 5;
    faces.insert(faces.end(), {{0, a, b}, {a, c, b}, {b, c, d}, {11, d, c}});
  }
  return make_mesh(positions, faces);
}

}  // namespace

PolygonMesh icosphere(int level) {
  PolygonMesh mesh = icosahedron();
  for (int l = 0; l < level; ++l) {
    std::vector<dvec3> positions = mesh.positions;
    std::map<std::pair<int32_t, int32_t>, int32_t> middles;
    const auto middle = [&](int32_t a, int32_t b) {
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), int32_t(positions.size()));
      if (is_new) positions.push_back(glm::normalize(positions[a] + positions[b]));
      return at->second;
    };
    FaceList faces;
    for (const auto& f : faces_of(mesh)) {
      const int32_t ab = middle(f[0], f[1]), bc = middle(f[1], f[2]), ca = middle(f[2], f[0]);
      faces.insert(faces.end(), {{f[0], ab, ca}, {f[1], bc, ab}, {f[2], ca, bc}, {ab, bc, ca}});
    }
    mesh = make_mesh(positions, faces);
  }
  return mesh;
}

PolygonMesh creased_cube() {
  PolygonMesh mesh = cube();
  for (int32_t v = 0; v < 8; ++v)
    for (const int32_t bit : {1, 2, 4})
      if ((v & bit) == 0) mesh.creases.push_back({v, v | bit});
  return mesh;
}

PolygonMesh cube_with_split_edges() {
  const PolygonMesh solid = cube();
  std::vector<dvec3> positions = solid.positions;
  std::map<std::pair<int32_t, int32_t>, int32_t> middles;
  FaceList faces;
  for (const auto& face : faces_of(solid)) {
    std::vector<int32_t> octagon;
    for (std::size_t i = 0; i < 4; ++i) {
      const int32_t a = face[i], b = face[(i + 1) % 4];
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), int32_t(positions.size()));
      if (is_new) positions.push_back((positions[a] + positions[b]) * 0.6);
      octagon.insert(octagon.end(), {a, at->second});
    }
    faces.push_back(octagon);
  }
  return make_mesh(positions, faces);
}

PolygonMesh rounded_box(const dvec3& half, double radius, int steps) {
  PolygonMesh mesh;
  std::map<std::array<std::int64_t, 3>, int32_t> vertices;
  const auto add = [&](const dvec3& p) {
    const auto key = [](double x) { return std::llround(x * 1e9); };
    const auto [at, is_new] = vertices.try_emplace({key(p.x), key(p.y), key(p.z)},
                                                   static_cast<int32_t>(mesh.positions.size()));
    if (is_new) mesh.positions.push_back(p);
    return at->second;
  };
  // Quarter by quarter: both ends of each, between which the planes lie.
  const int columns = 4 * (steps + 1), rows = 2 * (steps + 1);
  const auto angle = [&](int i) { return std::numbers::pi / 2 * (i % (steps + 1)) / steps; };
  const auto at = [&](int row, int column) {
    column %= columns;
    const int turn = column / (steps + 1), upper = row / (steps + 1);
    const double around = std::numbers::pi / 2 * turn + angle(column);
    const double up = angle(row) - (upper == 0 ? std::numbers::pi / 2 : 0);
    const dvec3 centre(turn % 3 == 0 ? half.x : -half.x, turn < 2 ? half.y : -half.y,
                       upper == 0 ? -half.z : half.z);
    return add(centre + radius * dvec3(std::cos(up) * std::cos(around),
                                       std::cos(up) * std::sin(around), std::sin(up)));
  };
  const auto add_face = [&](const std::vector<int32_t>& corners) {
    std::vector<int32_t> face;
    for (const int32_t v : corners)
      if (std::ranges::find(face, v) == face.end()) face.push_back(v);
    if (face.size() > 2) mesh.add_face(face);
  };
  for (int row = 0; row + 1 < rows; ++row)
    for (int i = 0; i < columns; ++i)
      add_face({at(row, i), at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)});
  std::vector<int32_t> bottom, top;
  for (int i = 0; i < columns; ++i) {
    bottom.push_back(at(0, columns - 1 - i));
    top.push_back(at(rows - 1, i));
  }
  add_face(bottom);
  add_face(top);
  return mesh;
}

PolygonMesh slot(int steps) {
  PolygonMesh mesh;
  const int count = 2 * (steps + 1);
  for (const double z : {0.0, 1.0})
    for (int i = 0; i < count; ++i) {
      const int side = i / (steps + 1);
      const double angle = std::numbers::pi * (side - 0.5 + double(i % (steps + 1)) / steps);
      mesh.positions.emplace_back(std::cos(angle) + (side == 0 ? 1 : -1), std::sin(angle), z);
    }
  std::vector<int32_t> bottom, top;
  for (int i = 0; i < count; ++i) {
    const int j = (i + 1) % count;
    mesh.add_face(std::array{i, j, count + j, count + i});
    mesh.creases.insert(mesh.creases.end(), {{i, j}, {count + i, count + j}});
    bottom.push_back(count - 1 - i);
    top.push_back(count + i);
  }
  mesh.add_face(bottom);
  mesh.add_face(top);
  return mesh;
}

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
