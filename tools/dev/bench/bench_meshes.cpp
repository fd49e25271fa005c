#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "bench/benchmarks.h"

namespace planish::bench {
namespace {

PolygonMesh icosahedron() {
  constexpr double kPhi = std::numbers::phi;
  PolygonMesh mesh;
  mesh.positions = {{-1, kPhi, 0}, {1, kPhi, 0}, {-1, -kPhi, 0}, {1, -kPhi, 0},
                    {0, -1, kPhi}, {0, 1, kPhi}, {0, -1, -kPhi}, {0, 1, -kPhi},
                    {kPhi, 0, -1}, {kPhi, 0, 1}, {-kPhi, 0, -1}, {-kPhi, 0, 1}};
  constexpr std::int32_t kFaces[20][3] = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (const auto& face : kFaces) mesh.add_face(face);
  return mesh;
}

PolygonMesh split_triangles(const PolygonMesh& coarse) {
  PolygonMesh fine;
  fine.positions = coarse.positions;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto [place, is_new] = middles.try_emplace(std::minmax(a, b), fine.vertex_count());
    if (is_new) fine.positions.push_back((fine.positions[a] + fine.positions[b]) / 2.0);
    return place->second;
  };
  for (std::int32_t f = 0; f < coarse.face_count(); ++f) {
    const auto v = coarse.face(f);
    const std::array<std::int32_t, 3> m = {middle(v[0], v[1]), middle(v[1], v[2]),
                                           middle(v[2], v[0])};
    for (int k = 0; k < 3; ++k) {
      fine.add_face(std::array<std::int32_t, 3>{v[k], m[k], m[(k + 2) % 3]});
    }
    fine.add_face(m);
  }
  return fine;
}

void append_number(std::string& text, double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(digits.data(), end);
}

// The vertices of an n by n torus, moved by what `move` returns, in edges.
template <class Move>
PolygonMesh torus_points(std::int32_t n, const Move& move) {
  PolygonMesh mesh;
  mesh.positions.reserve(static_cast<std::size_t>(n) * n);
  for (std::int32_t j = 0; j < n; ++j) {
    for (std::int32_t i = 0; i < n; ++i) {
      const double u = 2 * std::numbers::pi * (i + move()) / n;
      const double v = 2 * std::numbers::pi * (j + move()) / n;
      const double radius = 1 + 0.4 * std::cos(v);
      mesh.positions.push_back({radius * std::cos(u), radius * std::sin(u), 0.4 * std::sin(v)});
    }
  }
  return mesh;
}

// Calls add(corners) for the quads of an n by n torus.
template <class Add>
void for_torus_quads(std::int32_t n, const Add& add) {
  for (std::int32_t j = 0; j < n; ++j) {
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t i1 = (i + 1) % n, j1 = (j + 1) % n;
      add(std::array{j * n + i, j * n + i1, j1 * n + i1, j1 * n + i});
    }
  }
}

std::int32_t side_of(std::int32_t quad_count) {
  return static_cast<std::int32_t>(std::lround(std::sqrt(quad_count)));
}

}  // namespace

PolygonMesh torus_grid(std::int32_t quad_count) {
  const std::int32_t n = side_of(quad_count);
  PolygonMesh mesh = torus_points(n, [] { return 0; });
  for_torus_quads(n, [&](const auto& quad) { mesh.add_face(quad); });
  return mesh;
}

PolygonMesh irregular_triangles(std::int32_t quad_count) {
  const std::int32_t n = side_of(quad_count);
  std::mt19937 random(1);
  // The generator's own numbers: standard distributions differ between libraries.
  PolygonMesh mesh = torus_points(n, [&] { return 0.4 * (random() / 4294967295.0 - 0.5); });
  for_torus_quads(n, [&](const std::array<std::int32_t, 4>& q) {
    const std::size_t k = random() % 2;
    mesh.add_face(std::array{q[k], q[k + 1], q[k + 2]});
    mesh.add_face(std::array{q[k], q[k + 2], q[(k + 3) % 4]});
  });
  return mesh;
}

PolygonMesh rough_icosphere(int level) {
  PolygonMesh mesh = icosahedron();
  for (int l = 0; l < level; ++l) mesh = split_triangles(mesh);
  std::mt19937 random(1);
  for (glm::dvec3& position : mesh.positions) {
    // The generator's own numbers: standard distributions differ between libraries.
    const double share = random() / 4294967295.0;
    position = glm::normalize(position) * (0.99 + 0.02 * share);
  }
  return mesh;
}

PolygonMesh uneven_bipyramid(std::int32_t valence) {
  PolygonMesh mesh;
  mesh.positions = {{0.4, 0.1, 0.3}, {-0.3, 0.2, -0.2}};
  for (std::int32_t i = 0; i < valence; ++i) {
    const double angle = 2 * std::numbers::pi * i / valence;
    const double radius = 1 + 0.3 * std::sin(5 * angle);
    mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                0.1 * std::cos(3 * angle));
  }
  for (std::int32_t i = 0; i < valence; ++i) {
    const std::int32_t own = 2 + i, next = 2 + (i + 1) % valence;
    mesh.add_face(std::array{0, own, next});
    mesh.add_face(std::array{1, next, own});
  }
  return mesh;
}

std::string obj_text(const PolygonMesh& mesh) {
  std::string text;
  for (const glm::dvec3& position : mesh.positions) {
    text += 'v';
    for (int k = 0; k < 3; ++k) {
      text += ' ';
      append_number(text, position[k]);
    }
    text += '\n';
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    text += 'f';
    for (const std::int32_t v : mesh.face(f)) text += ' ' + std::to_string(v + 1);
    text += '\n';
  }
  return text;
}

namespace {

constexpr double kFramesPerSecond = 60;
constexpr double kTwist = 0.5;      // radians a unit of length
constexpr double kRoughness = 0.1;  // of an edge

}  // namespace

PolygonMesh rough_torus(std::int32_t point_count) {
  PolygonMesh mesh = torus_grid(point_count);
  // Along the circle R = 1; those of the tube are shorter.
  const double edge = 2 * std::numbers::pi / std::sqrt(mesh.vertex_count());
  std::mt19937 random(1);
  for (glm::dvec3& position : mesh.positions)
    // The generator's own numbers: standard distributions differ between libraries.
    for (int k = 0; k < 3; ++k)
      position[k] += kRoughness * edge * (2 * (random() / 4294967295.0) - 1);
  return mesh;
}

std::vector<glm::vec3> twisted(const PolygonMesh& rest, int frame) {
  const double twist = kTwist * std::sin(2 * std::numbers::pi * frame / kFramesPerSecond);
  std::vector<glm::vec3> pose;
  pose.reserve(rest.positions.size());
  for (const glm::dvec3& p : rest.positions) {
    const double sine = std::sin(twist * p.x), cosine = std::cos(twist * p.x);
    pose.emplace_back(p.x, cosine * p.y - sine * p.z, sine * p.y + cosine * p.z);
  }
  return pose;
}

}  // namespace planish::bench
