#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// A mesh with a name for messages.
struct NamedMesh {
  std::string name;
  PolygonMesh mesh;
};

using FaceList = std::vector<std::vector<std::int32_t>>;

[[nodiscard]] PolygonMesh make_mesh(std::vector<glm::dvec3> positions, const FaceList& faces);
[[nodiscard]] FaceList faces_of(const PolygonMesh& mesh);

// Closed.
[[nodiscard]] PolygonMesh tetrahedron();
/// Side 2, centred, vertices in binary order: x = bit 0, y = bit 1, z = bit 2.
[[nodiscard]] PolygonMesh cube();
[[nodiscard]] PolygonMesh dodecahedron();
/// Two n-gons joined by n quads.
[[nodiscard]] PolygonMesh prism(int n);
/// A prism of n walls whose ends have chamfers all around: 2 n-gons and 3 n quads.
[[nodiscard]] PolygonMesh chamfered_prism(int n);
/// Two apexes of valence n over a ring of n vertices.
[[nodiscard]] PolygonMesh bipyramid(int n);
/// `around` x `across` quads; the tube's circle has radius `minor`.
[[nodiscard]] PolygonMesh torus(int around, int across, double major, double minor);
/// 10 * 4^level + 2 vertices on the unit sphere.
[[nodiscard]] PolygonMesh icosphere(int level);
/// A box of the half sizes `half` and all that is nearer to it than `radius`: six planes, between
/// them parts of cylinders and of spheres in so many steps a quarter.
[[nodiscard]] PolygonMesh rounded_box(const glm::dvec3& half, double radius, int steps);
/// Two planes with a quarter round of six steps between them, all along as wide.
[[nodiscard]] PolygonMesh plane_and_quarter_round();
/// Two half rounds of so many steps and two planes between them, and a face below and above behind
/// edges that are tagged.
[[nodiscard]] PolygonMesh slot(int steps);
/// The cube with all of its edges tagged sharp.
[[nodiscard]] PolygonMesh creased_cube();
/// The cube with a vertex in the middle of every edge: octagons and valence 2.
[[nodiscard]] PolygonMesh cube_with_split_edges();

// Open.
/// `columns` x `rows` quads over [0, columns] x [0, rows]; vertex (i, j) has index
/// j * (columns + 1) + i and lies at shape(i, j).
[[nodiscard]] PolygonMesh grid(int columns, int rows,
                               const std::function<glm::dvec3(double, double)>& shape);
[[nodiscard]] PolygonMesh flat_grid(int columns, int rows);
/// A flat n x n grid without its middle ones; n >= 5.
[[nodiscard]] PolygonMesh plate_with_hole(int n);
/// A flat 2n x 2n grid without the quadrant x > n, y > n.
[[nodiscard]] PolygonMesh l_shaped_plate(int n);
/// A flat polygon of n sides as one face.
[[nodiscard]] PolygonMesh single_polygon(int n);
/// n triangles around a centre.
[[nodiscard]] PolygonMesh open_fan(int n);
/// Three sheets at one bent line, each in another direction and with cells of its own widths: edges
/// with three faces, which repair() separates. Its first kBentEdges + 1 vertices are the line.
inline constexpr int kBentEdges = 6;
[[nodiscard]] PolygonMesh bent_sheets();

/// A grid of quads with (columns + 1) x (rows + 1) texture coordinates; `at` gives the points of
/// (u, v) in 0 to 1, one for those that fall together where it closes.
inline PolygonMesh mapped_grid(
    int columns, int rows, bool closes_u, bool closes_v,
    const std::function<glm::dvec3(double, double)>& at,
    const std::function<glm::dvec2(double, double)>& uv_at = [](double u, double v) {
      return glm::dvec2(u, v);
    }) {
  PolygonMesh mesh;
  const int across = columns + (closes_u ? 0 : 1), up = rows + (closes_v ? 0 : 1);
  for (int j = 0; j < up; ++j)
    for (int i = 0; i < across; ++i)
      mesh.positions.push_back(at(double(i) / columns, double(j) / rows));
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i)
      mesh.uvs.push_back(uv_at(double(i) / columns, double(j) / rows));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      std::vector<std::int32_t> face;
      for (const auto& [di, dj] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        face.push_back((j + dj) % up * across + (i + di) % across);
        mesh.face_uvs.push_back((j + dj) * (columns + 1) + i + di);
      }
      mesh.add_face(face);
    }
  return mesh;
}

/// Index of the vertex nearest to `point`.
[[nodiscard]] std::int32_t vertex_at(const PolygonMesh& mesh, const glm::dvec3& point);

/// The side of a cone over the unit circle: `rings` circles of n vertices from the inside out, then
/// the apex at (0, 0, height); triangles around it, then quads.
inline PolygonMesh cone(int n, double height, int rings = 1) {
  PolygonMesh mesh;
  for (int ring = 1; ring <= rings; ++ring) {
    const double radius = static_cast<double>(ring) / rings;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                  (1 - radius) * height);
    }
  }
  mesh.positions.emplace_back(0, 0, height);
  for (int i = 0; i < n; ++i) mesh.add_face(std::vector{i, (i + 1) % n, n * rings});
  for (int ring = 1; ring < rings; ++ring) {
    const int inner = (ring - 1) * n, outer = ring * n;
    for (int i = 0; i < n; ++i)
      mesh.add_face(std::vector{outer + i, outer + (i + 1) % n, inner + (i + 1) % n, inner + i});
  }
  return mesh;
}

/// The face under its last circle.
inline PolygonMesh with_base(PolygonMesh cone, int n) {
  std::vector<std::int32_t> base;
  for (int i = 1; i <= n; ++i) base.push_back(cone.vertex_count() - 1 - i);
  cone.add_face(base);
  return cone;
}

}  // namespace planish::test
