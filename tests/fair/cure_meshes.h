#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {

/// A cylinder as CAD programs cut it: needles along it, caps as fans around one vertex of the rim.
inline PolygonMesh needle_rod(int sides, double length) {
  PolygonMesh mesh;
  for (const double z : {0.0, length}) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.positions.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle), z);
    }
  }
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    mesh.add_face(std::array{i, next, next + sides});
    mesh.add_face(std::array{i, next + sides, i + sides});
    if (i == 0 || next == 0) continue;
    mesh.add_face(std::array{0, next, i});
    mesh.add_face(std::array{sides, i + sides, next + sides});
  }
  return mesh;
}

/// A flat ellipse and a circle far above it, turned: needles that wind about hubs of sharp rims,
/// caps as fans.
inline PolygonMesh needle_loft(int sides) {
  PolygonMesh mesh;
  for (const bool is_top : {false, true}) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides + (is_top ? 1.2 : 0);
      mesh.positions.emplace_back((is_top ? 0.4 : 2) * std::cos(angle),
                                  (is_top ? 0.4 : 0.2) * std::sin(angle), is_top ? 4 : 0);
    }
  }
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    mesh.add_face(std::array{i, next, sides + i});
    mesh.add_face(std::array{next, sides + next, sides + i});
    if (i == 0 || next == 0) continue;
    mesh.add_face(std::array{0, next, i});
    mesh.add_face(std::array{sides, sides + i, sides + next});
  }
  return mesh;
}

/// Triangles whose sides are up to 20 times as long as others', on a box with sharp edges.
inline PolygonMesh uneven_box() {
  const std::array<double, 6> lines{0, 1, 1.05, 1.5, 1.52, 3};
  PolygonMesh mesh;
  std::vector<int> index(216, -1);
  const auto vertex = [&](int i, int j, int k) {
    int& known = index[36 * i + 6 * j + k];
    if (known < 0) {
      known = mesh.vertex_count();
      mesh.positions.emplace_back(lines[i], 3 - lines[5 - j], 0.4 * lines[k]);
    }
    return known;
  };
  const auto side = [&](const auto& at, bool turned) {
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < 5; ++j) {
        const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
        mesh.add_face(turned ? std::array{a, c, b} : std::array{a, b, c});
        mesh.add_face(turned ? std::array{a, d, c} : std::array{a, c, d});
      }
    }
  };
  for (const int end : {0, 5}) {
    side([&](int i, int j) { return vertex(i, j, end); }, end == 0);
    side([&](int i, int j) { return vertex(end, i, j); }, end == 0);
    side([&](int i, int j) { return vertex(j, end, i); }, end == 0);
  }
  return mesh;
}

/// The rod with its two rims tagged sharp: each is a crease with needles on one side and hubs of
/// the caps on the other.
inline PolygonMesh creased_rod(int sides, double length) {
  PolygonMesh mesh = needle_rod(sides, length);
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    mesh.creases.push_back({i, next, kInfiniteSharpness});
    mesh.creases.push_back({i + sides, next + sides, kInfiniteSharpness});
  }
  return mesh;
}

/// Without caps: boundaries with needles beside them. `zigzag`: how far every other vertex of the
/// rims is drawn in.
inline PolygonMesh needle_tube(int sides, double length, double zigzag) {
  PolygonMesh mesh = needle_rod(sides, length);
  PolygonMesh tube;
  tube.positions = mesh.positions;
  for (int i = 0; i < 2 * sides; i += 2) tube.positions[i].z += zigzag;
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    tube.add_face(std::array{i, next, next + sides});
    tube.add_face(std::array{i, next + sides, i + sides});
  }
  return tube;
}

/// Triangles around one vertex through `turn` of a full turn, with heights by turns: at the tip of
/// a slit where that is nearly 1.
inline PolygonMesh slit_fan(int count, double turn) {
  PolygonMesh mesh;
  mesh.positions.emplace_back(0, 0, 0);
  for (int i = 0; i <= count; ++i) {
    const double angle = turn * 2 * std::numbers::pi * i / count;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), i % 2 ? 0.2 : 0.0);
  }
  for (int i = 1; i <= count; ++i) mesh.add_face(std::array{0, i, i + 1});
  return mesh;
}

/// Meshes whose fair nets need the cure, at vertices of every kind.
[[nodiscard]] inline std::vector<NamedMesh> cure_meshes() {
  std::vector<NamedMesh> meshes;
  meshes.push_back({"needle rod", needle_rod(48, 10)});
  meshes.push_back({"thin needle rod", needle_rod(72, 30)});
  meshes.push_back({"hubs of 400", needle_rod(400, 3)});
  meshes.push_back({"uneven box", uneven_box()});
  meshes.push_back({"creased rod", creased_rod(24, 6)});
  meshes.push_back({"needle tube", needle_tube(36, 12, 0)});
  meshes.push_back({"zigzag tube", needle_tube(24, 2, 0.4)});
  meshes.push_back({"slit", slit_fan(16, 0.999)});
  meshes.push_back({"wound fan", slit_fan(16, 1.1)});
  meshes.push_back({"boundary hub", slit_fan(200, 0.4)});
  meshes.push_back({"jittered sphere", jittered(icosphere(3), 0.6, 2)});
  meshes.push_back({"jittered tube", jittered(needle_tube(24, 4, 0.3), 0.2, 3)});
  meshes.push_back(
      {"jittered creases", with_random_creases(jittered(icosphere(2), 0.5, 4), 0.2, 5)});
  return meshes;
}

}  // namespace planish::test
