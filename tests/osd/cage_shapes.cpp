#include <cmath>
#include <numbers>

#include "osd/cages.h"

namespace planish::testing {

namespace {

constexpr double kPi = std::numbers::pi;

std::array<float, 3> point(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

/// A point of a ring of `count` around z, at radius 1.
std::array<float, 3> on_ring(int i, int count, double radius, double z) {
  const double angle = 2 * kPi * i / count;
  return point(radius * std::cos(angle), radius * std::sin(angle), z);
}

/// Quads of width x height vertices, with wrap-around where asked for.
void add_quads(Cage& cage, int width, int height, bool wrap_x, bool wrap_y) {
  for (int y = 0; y < (wrap_y ? height : height - 1); ++y)
    for (int x = 0; x < (wrap_x ? width : width - 1); ++x) {
      const int right = (x + 1) % width, up = (y + 1) % height;
      cage.add_face({y * width + x, y * width + right, up * width + right, up * width + x});
    }
}

/// Every quad becomes two triangles.
Cage split(const Cage& quads) {
  Cage result = quads;
  result.face_sizes.clear();
  result.corners.clear();
  for (std::size_t i = 0; i < quads.corners.size(); i += 4) {
    const int* v = &quads.corners[i];
    result.add_face({v[0], v[1], v[2]});
    result.add_face({v[0], v[2], v[3]});
  }
  return result;
}

}  // namespace

void Cage::add_face(const std::vector<int>& vertices) {
  face_sizes.push_back(static_cast<int>(vertices.size()));
  corners.insert(corners.end(), vertices.begin(), vertices.end());
}

void Cage::crease(int a, int b, float sharpness) {
  crease_pairs.insert(crease_pairs.end(), {a, b});
  crease_sharpness.push_back(sharpness);
}

void Cage::corner(int vertex, float sharpness) {
  corner_vertices.push_back(vertex);
  corner_sharpness.push_back(sharpness);
}

Cage cube() {
  Cage cage;
  for (int i = 0; i < 8; ++i) cage.positions.push_back(point(i & 1, (i >> 1) & 1, (i >> 2) & 1));
  for (const auto& face : std::vector<std::vector<int>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    cage.add_face(face);
  return cage;
}

Cage tetrahedron() {
  Cage cage;
  cage.positions = {point(1, 1, 1), point(1, -1, -1), point(-1, 1, -1), point(-1, -1, 1)};
  for (const auto& face : std::vector<std::vector<int>>{{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}})
    cage.add_face(face);
  return cage;
}

Cage bipyramid(int sides) {
  Cage cage;
  for (int i = 0; i < sides; ++i) cage.positions.push_back(on_ring(i, sides, 1, 0));
  cage.positions.push_back(point(0, 0, 1.2));
  cage.positions.push_back(point(0.1, 0, -0.9));
  for (int i = 0; i < sides; ++i) {
    cage.add_face({i, (i + 1) % sides, sides});
    cage.add_face({(i + 1) % sides, i, sides + 1});
  }
  return cage;
}

Cage icosahedron() {
  Cage cage;
  for (int i = 0; i < 5; ++i) cage.positions.push_back(on_ring(i, 5, 1, -0.5));
  for (int i = 0; i < 5; ++i) cage.positions.push_back(on_ring(2 * i + 1, 10, 1, 0.5));
  cage.positions.push_back(point(0, 0, -1.1));
  cage.positions.push_back(point(0, 0, 1.1));
  for (int i = 0; i < 5; ++i) {
    const int next = (i + 1) % 5;
    cage.add_face({next, i, 10});
    cage.add_face({i, next, 5 + i});
    cage.add_face({5 + next, 5 + i, next});
    cage.add_face({5 + i, 5 + next, 11});
  }
  return cage;
}

Cage pyramid(int sides) {
  Cage cage;
  std::vector<int> base;
  for (int i = 0; i < sides; ++i) {
    cage.positions.push_back(on_ring(i, sides, 1, 0));
    base.insert(base.begin(), i);
  }
  cage.positions.push_back(point(0.1, 0.05, 1.3));
  for (int i = 0; i < sides; ++i) cage.add_face({i, (i + 1) % sides, sides});
  cage.add_face(base);
  return cage;
}

Cage prism(int sides) {
  Cage cage;
  std::vector<int> bottom, top;
  for (int i = 0; i < 2 * sides; ++i)
    cage.positions.push_back(on_ring(i % sides, sides, i < sides ? 1 : 0.8, i < sides ? 0 : 1));
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    cage.add_face({i, next, sides + next, sides + i});
    bottom.insert(bottom.begin(), i);
    top.push_back(sides + i);
  }
  cage.add_face(bottom);
  cage.add_face(top);
  return cage;
}

Cage torus(int width, int height) {
  Cage cage;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double angle = 2 * kPi * y / height;
      cage.positions.push_back(on_ring(x, width, 1 + 0.4 * std::cos(angle), 0.4 * std::sin(angle)));
    }
  add_quads(cage, width, height, true, true);
  return cage;
}

Cage triangle_torus(int width, int height) { return split(torus(width, height)); }

Cage sphere(int around, int rings) {
  Cage cage;
  for (int y = 0; y < rings; ++y)
    for (int x = 0; x < around; ++x) {
      const double angle = kPi * (y + 1) / (rings + 1);
      cage.positions.push_back(on_ring(x, around, std::sin(angle), -std::cos(angle)));
    }
  add_quads(cage, around, rings, true, false);
  const int south = around * rings, last = around * (rings - 1);
  cage.positions.push_back(point(0, 0, -1));
  cage.positions.push_back(point(0, 0, 1));
  for (int x = 0; x < around; ++x) {
    const int next = (x + 1) % around;
    cage.add_face({next, x, south});
    cage.add_face({last + x, last + next, south + 1});
  }
  return cage;
}

Cage grid(int width, int height) {
  Cage cage;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      cage.positions.push_back(
          point(x - width / 2.0, y - height / 2.0, 0.5 * std::sin(x + 2.0 * y)));
  add_quads(cage, width, height, false, false);
  return cage;
}

Cage triangle_grid(int width, int height) { return split(grid(width, height)); }

Cage tube(int around, int height) {
  Cage cage;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < around; ++x)
      cage.positions.push_back(on_ring(x, around, 1 + 0.1 * y, 0.6 * y));
  add_quads(cage, around, height, true, false);
  return cage;
}

Cage mobius(int around) {
  Cage cage;
  for (int x = 0; x < around; ++x)
    for (int side : {-1, 1}) {
      const double turn = kPi * x / around;
      cage.positions.push_back(
          on_ring(x, around, 1 + 0.3 * side * std::cos(turn), 0.3 * side * std::sin(turn)));
    }
  for (int x = 0; x + 1 < around; ++x) cage.add_face({2 * x, 2 * x + 2, 2 * x + 3, 2 * x + 1});
  cage.add_face({2 * around - 2, 1, 0, 2 * around - 1});
  return cage;
}

Cage pillow() {
  Cage cage;
  for (int i = 0; i < 4; ++i) cage.positions.push_back(on_ring(i, 4, 1, 0.2 * (i % 2)));
  cage.add_face({0, 1, 2, 3});
  cage.add_face({3, 2, 1, 0});
  return cage;
}

Cage fan_of_pages(int pages) {
  Cage cage;
  cage.positions = {point(0, 0, 0), point(0, 0, 1)};
  for (int i = 0; i < pages; ++i) {
    const int outer = static_cast<int>(cage.positions.size());
    cage.positions.push_back(on_ring(i, pages, 1, 0));
    cage.positions.push_back(on_ring(i, pages, 1.1, 1));
    cage.add_face({0, outer, outer + 1, 1});
  }
  return cage;
}

Cage bow_tie() {
  Cage cage = cube();
  const Cage other = cube();
  // Its corner 0 is the first one's corner 7.
  const auto moved = [](int vertex) { return vertex == 0 ? 7 : 7 + vertex; };
  for (std::size_t i = 1; i < other.positions.size(); ++i) {
    std::array<float, 3> position = other.positions[i];
    for (float& coordinate : position) coordinate += 1;
    cage.positions.push_back(position);
  }
  for (std::size_t i = 0; i < other.corners.size(); i += 4)
    cage.add_face({moved(other.corners[i]), moved(other.corners[i + 1]),
                   moved(other.corners[i + 2]), moved(other.corners[i + 3])});
  return cage;
}

}  // namespace planish::testing
