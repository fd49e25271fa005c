#include "quality/wild_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <vector>

#include "make_scenes/bust.h"
#include "make_scenes/implicit.h"
#include "make_scenes/random_numbers.h"
#include "make_scenes/shapes.h"
#include "make_scenes/surface_nets.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/repair.h"
#include "planish/mesh/triangle_edges.h"
#include "planish/mesh/used_vertices.h"
#include "planish/reconstruct/simplify.h"

namespace planish::quality {

namespace {

using glm::dvec3;
using shapes::RandomNumbers;

constexpr double kTurn = 2 * std::numbers::pi;

void add_triangle(PolygonMesh& mesh, std::int32_t a, std::int32_t b, std::int32_t c) {
  mesh.add_face(std::array{a, b, c});
}

// A grid of rings[i] x sides, closed around: two triangles a cell, the diagonal by lot.
void add_band(PolygonMesh& mesh, std::int32_t first, std::int32_t sides, RandomNumbers& random) {
  for (std::int32_t i = 0; i < sides; ++i) {
    const std::int32_t a = first + i, b = first + (i + 1) % sides, c = b + sides, d = a + sides;
    if (random.below(2) == 0) {
      add_triangle(mesh, a, b, c);
      add_triangle(mesh, a, c, d);
    } else {
      add_triangle(mesh, a, b, d);
      add_triangle(mesh, b, c, d);
    }
  }
}

// Every quad as two triangles, the diagonal by lot.
void add_cut_quads(const PolygonMesh& quads, PolygonMesh& triangles, RandomNumbers& random) {
  for (std::int32_t f = 0; f < quads.face_count(); ++f) {
    const auto v = quads.face(f);
    const int first = random.below(2);
    for (const int k : {first, first + 2}) {
      add_triangle(triangles, v[k % 4], v[(k + 1) % 4], v[(k + 2) % 4]);
    }
  }
}

// Without the faces, and made a mesh that passes check().
PolygonMesh without_faces(const PolygonMesh& mesh, const std::set<std::int32_t>& dropped) {
  PolygonMesh rest;
  rest.positions = mesh.positions;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (!dropped.contains(f)) rest.add_face(mesh.face(f));
  }
  return without_unused_vertices(repair(rest).mesh).mesh;
}

std::vector<Triangle> fans_of(const PolygonMesh& mesh) {
  std::vector<Triangle> triangles;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto v = mesh.face(f);
    for (std::size_t i = 1; i + 1 < v.size(); ++i) triangles.push_back({v[0], v[i], v[i + 1]});
  }
  return triangles;
}

}  // namespace

PolygonMesh simplified(const PolygonMesh& mesh, double tolerance, std::int64_t target_vertices) {
  const SimplifiedMesh simple = simplify(
      mesh.positions, fans_of(mesh),
      {.tolerance = tolerance * placement_of(mesh).diagonal, .target_vertices = target_vertices});
  PolygonMesh result = polygons_of(simple.triangles);
  result.positions = mesh.positions;
  return without_unused_vertices(result).mesh;
}

PolygonMesh holed_sphere(std::int32_t level, std::int32_t holes, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh = shapes::icosphere(level);
  std::set<std::int32_t> dropped;
  for (std::int32_t hole = 0; hole < holes; ++hole) {
    const std::int32_t middle = random.below(mesh.face_count());
    const dvec3 centre = mesh.positions[mesh.face(middle)[0]];
    const double size = 0.25 + 0.5 * random.unit();
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto v = mesh.face(f);
      const dvec3 mean = (mesh.positions[v[0]] + mesh.positions[v[1]] + mesh.positions[v[2]]) / 3.0;
      if (f == middle || glm::distance(mean, centre) < size) dropped.insert(f);
    }
  }
  const double edge = 1.1 * std::ldexp(1.0, -level);
  for (dvec3& p : mesh.positions) {
    p += 0.2 * edge * dvec3(random.sway(), random.sway(), random.sway());
  }
  return without_faces(mesh, dropped);
}

PolygonMesh zigzag_tube(std::int32_t sides, std::int32_t rings, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh;
  const double step = kTurn / sides;
  for (std::int32_t r = 0; r < rings; ++r) {
    const bool is_end = r == 0 || r + 1 == rings;
    for (std::int32_t i = 0; i < sides; ++i) {
      const double angle = step * (i + (is_end ? 0.6 * random.sway() : 0.2 * random.sway()));
      const double tooth = is_end ? (i % 2 == 0 ? 0.7 : -0.3) * step * (r == 0 ? -1 : 1) : 0.0;
      mesh.positions.emplace_back(std::cos(angle), std::sin(angle),
                                  1.4 * step * r + tooth + 0.2 * step * random.sway());
    }
  }
  for (std::int32_t r = 0; r + 1 < rings; ++r) add_band(mesh, r * sides, sides, random);
  return mesh;
}

PolygonMesh holed_disc(std::int32_t sides, std::int32_t rings, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh;
  for (std::int32_t r = 1; r <= rings; ++r) {
    for (std::int32_t i = 0; i < sides; ++i) {
      const double angle = kTurn * (i + 0.5 * random.sway()) / sides;
      const double radius = r + (r == rings && i % 2 == 0 ? 0.8 : 0.25 * random.sway());
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                  0.1 * random.sway());
    }
  }
  for (std::int32_t r = 0; r + 1 < rings; ++r) add_band(mesh, r * sides, sides, random);
  // Bands run inwards seen from above: turn them, then close the middle.
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::swap(mesh.face_vertices[3 * f + 1], mesh.face_vertices[3 * f + 2]);
  }
  const std::int32_t centre = mesh.vertex_count();
  mesh.positions.emplace_back(0.0, 0.0, 0.0);
  for (std::int32_t i = 0; i < sides; ++i) add_triangle(mesh, centre, i, (i + 1) % sides);
  std::set<std::int32_t> dropped;
  for (std::int32_t hole = 0; hole < sides / 3; ++hole) {
    dropped.insert(random.below(mesh.face_count()));
  }
  return without_faces(mesh, dropped);
}

PolygonMesh needle_sheet(std::int32_t cells, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh = shapes::wavy_patch(cells, cells);
  const double cell = 1.0 / cells;
  const std::int32_t row = cells + 1;
  const auto inner = [&](std::int32_t k) { return k > 0 && k < cells; };
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (inner(v % row) && inner(v / row)) {
      mesh.positions[v] += 0.3 * cell * dvec3(random.sway(), random.sway(), 0.3 * random.sway());
    }
  }
  PolygonMesh triangles;
  triangles.positions = mesh.positions;
  add_cut_quads(mesh, triangles, random);
  // A needle on most edges of the side y = 0, its tip close to the edge or far along it.
  for (std::int32_t i = 0; i < cells; ++i) {
    if (random.unit() < 0.3) continue;
    const dvec3 a = mesh.positions[i], b = mesh.positions[i + 1];
    const double along = -0.2 + 1.4 * random.unit();
    triangles.positions.push_back(a + along * (b - a) - dvec3(0, 0.06 * cell, 0) +
                                  dvec3(0, 0, 0.02 * cell * random.sway()));
    add_triangle(triangles, i + 1, i, triangles.vertex_count() - 1);
  }
  return triangles;
}

PolygonMesh uneven_box(std::int32_t cells, std::uint32_t seed, bool cut) {
  RandomNumbers random(seed);
  PolygonMesh mesh = shapes::cube(cells);
  std::vector<double> lines{0.0};
  for (std::int32_t i = 0; i < cells; ++i) {
    lines.push_back(lines.back() + std::pow(20.0, random.unit()));
  }
  for (dvec3& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto line = static_cast<std::size_t>(std::lround((p[axis] + 1) / 2 * cells));
      p[axis] = lines[axis == 1 ? lines.size() - 1 - line : line] * (axis == 1 ? -1 : 1) *
                (axis == 2 ? 0.3 : 1.0);
    }
  }
  if (!cut) return mesh;
  PolygonMesh triangles;
  triangles.positions = mesh.positions;
  add_cut_quads(mesh, triangles, random);
  return triangles;
}

PolygonMesh spiked_star(std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh = shapes::icosphere(1);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (v < 12) mesh.positions[v] *= 2.0 + 1.5 * random.unit();
    mesh.positions[v] += 0.1 * dvec3(random.sway(), random.sway(), random.sway());
  }
  return mesh;
}

PolygonMesh low_poly_animal(std::int32_t vertices, std::uint32_t seed) {
  RandomNumbers random(seed);
  const auto about = [&](double x) { return x * (1 + 0.3 * random.sway()); };
  std::vector<shapes::Cone> limbs;
  const double length = about(1.2), hip = about(0.45), leg = about(0.9);
  limbs.push_back({{-length, 0, 0}, {length, 0, about(0.1)}, about(0.4), about(0.45)});
  for (const double x : {-length, length}) {
    for (const double y : {-1.0, 1.0}) {
      limbs.push_back(
          {{x, y * hip * 0.6, 0}, {x + 0.2 * random.sway(), y * hip, -leg - 0.3}, 0.22, 0.12});
    }
  }
  const dvec3 head(length + about(0.7), 0, about(0.8));
  limbs.push_back({{length, 0, 0.1}, head, 0.3, 0.2});
  limbs.push_back({head, head + dvec3(about(0.5), 0, -0.2), 0.27, 0.12});
  for (const double y : {-1.0, 1.0}) {
    limbs.push_back({head, head + dvec3(-0.1, y * about(0.3), about(0.4)), 0.12, 0.06});
  }
  limbs.push_back({{-length, 0, 0.1}, {-length - about(0.8), 0, about(0.4)}, 0.12, 0.07});
  const shapes::Field field = [limbs](const dvec3& p) {
    double distance = limbs[0](p);
    for (const shapes::Cone& limb : limbs) {
      distance = shapes::smooth_union(distance, limb(p), 0.05);
    }
    return distance;
  };
  const PolygonMesh fine =
      shapes::surface_nets(field, {.low = {-4, -2, -2.5}, .high = {4.5, 2, 2.5}, .cell = 0.09});
  return simplified(repair(fine).mesh, 0.03, vertices);
}

PolygonMesh decimated_head(double percent, double tolerance) {
  const PolygonMesh bust = shapes::bust();
  const auto target = static_cast<std::int64_t>(bust.vertex_count() * percent / 100);
  return simplified(bust, tolerance, target);
}

PolygonMesh needle_disc(std::int32_t sides, std::uint32_t seed) {
  RandomNumbers random(seed);
  constexpr double kHalfHeight = 0.04;
  PolygonMesh mesh;
  std::vector<double> angles;
  for (std::int32_t i = 0; i < sides; ++i) {
    angles.push_back(kTurn * (i + 0.4 * random.sway()) / sides);
  }
  for (const double z : {-kHalfHeight, kHalfHeight}) {
    for (const double angle : angles)
      mesh.positions.emplace_back(std::cos(angle), std::sin(angle), z);
  }
  add_band(mesh, 0, sides, random);
  for (const double z : {-kHalfHeight, kHalfHeight}) {
    const std::int32_t hub = mesh.vertex_count();
    mesh.positions.emplace_back(0.6 * random.unit(), 0.6 * random.sway(), z);
    for (std::int32_t i = 0; i < sides; ++i) {
      const std::int32_t next = (i + 1) % sides;
      z > 0 ? add_triangle(mesh, hub, sides + i, sides + next) : add_triangle(mesh, hub, next, i);
    }
  }
  return mesh;
}

PolygonMesh needle_spindle(std::int32_t sides, std::int32_t rings, double spindle) {
  RandomNumbers random(static_cast<std::uint32_t>(sides + rings));
  PolygonMesh mesh;
  for (std::int32_t r = 1; r <= rings; ++r) {
    const double angle = std::numbers::pi * r / (rings + 1);
    const double radius = std::sin(angle);
    const double z = spindle > 0 ? -spindle * std::cos(angle) : -std::cos(angle);
    for (std::int32_t i = 0; i < sides; ++i) {
      const double around = kTurn * i / sides;
      mesh.positions.emplace_back(radius * std::cos(around), radius * std::sin(around), z);
    }
  }
  for (std::int32_t r = 0; r + 1 < rings; ++r) add_band(mesh, r * sides, sides, random);
  const double end = spindle > 0 ? spindle : 1.0;
  for (const double side : {-1.0, 1.0}) {
    const std::int32_t pole = mesh.vertex_count();
    mesh.positions.emplace_back(0.0, 0.0, side * end);
    const std::int32_t first = side < 0 ? 0 : (rings - 1) * sides;
    for (std::int32_t i = 0; i < sides; ++i) {
      const std::int32_t a = first + i, b = first + (i + 1) % sides;
      side < 0 ? add_triangle(mesh, pole, b, a) : add_triangle(mesh, pole, a, b);
    }
  }
  return mesh;
}

PolygonMesh folded_sphere(std::int32_t count, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh = shapes::icosphere(2);
  for (std::int32_t i = 0; i < count; ++i) {
    dvec3& p = mesh.positions[random.below(mesh.vertex_count())];
    const dvec3 other = mesh.positions[random.below(mesh.vertex_count())];
    const dvec3 along = other - glm::dot(other, p) * p;
    if (glm::length(along) > 0.1) p += 0.55 * glm::normalize(along);
  }
  return mesh;
}

PolygonMesh three_sheets(std::int32_t cells, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh;
  const auto spine = [&](std::int32_t i) {
    const double x = 2.0 * i / cells;
    return dvec3(x, 0.2 * std::sin(2.5 * x), 0.15 * std::cos(4 * x));
  };
  for (std::int32_t i = 0; i <= cells; ++i) mesh.positions.push_back(spine(i));
  for (int sheet = 0; sheet < 3; ++sheet) {
    const double turn = kTurn * (sheet + 0.3 * random.sway()) / 3;
    const dvec3 out(0, std::cos(turn), std::sin(turn));
    const std::int32_t first = mesh.vertex_count();
    const auto at = [&](std::int32_t i, std::int32_t j) {
      return j == 0 ? i : first + (j - 1) * (cells + 1) + i;
    };
    for (std::int32_t j = 1; j <= cells / 2; ++j) {
      for (std::int32_t i = 0; i <= cells; ++i) {
        const double r = 2.0 * j / cells;
        mesh.positions.push_back(spine(i) + r * out + 0.15 * r * r * dvec3(random.sway(), 0, 0) +
                                 0.3 * r * r * dvec3(0, -out.z, out.y));
      }
    }
    for (std::int32_t j = 0; j < cells / 2; ++j) {
      for (std::int32_t i = 0; i < cells; ++i) {
        add_triangle(mesh, at(i, j), at(i + 1, j), at(i + 1, j + 1));
        add_triangle(mesh, at(i, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }
  return without_unused_vertices(repair(mesh).mesh).mesh;
}

PolygonMesh mitred_pipe(std::int32_t sides, double length, std::uint32_t seed) {
  RandomNumbers random(seed);
  const std::array<dvec3, 4> path{dvec3(0.0), dvec3(length, 0, 0), dvec3(length, 0.4 * length, 0),
                                  dvec3(1.05 * length, 0.45 * length, 0.45 * length)};
  std::vector<dvec3> ring;
  for (std::int32_t i = 0; i < sides; ++i) {
    const double angle = kTurn * i / sides;
    ring.emplace_back(0, 0.5 * std::cos(angle), 0.5 * std::sin(angle));
  }
  PolygonMesh mesh;
  for (std::size_t r = 0; r < path.size(); ++r) {
    const auto leg = [&](std::size_t to) { return glm::normalize(path[to] - path[to - 1]); };
    const dvec3 along = leg(std::max<std::size_t>(r, 1));
    const dvec3 mitre = along + (r == 0 || r + 1 == path.size() ? along : leg(r + 1));
    for (dvec3& p : ring) {
      p += glm::dot(path[r] - p, mitre) / glm::dot(along, mitre) * along;
      mesh.positions.push_back(p + 0.004 * dvec3(random.sway(), random.sway(), random.sway()));
    }
  }
  for (std::int32_t r = 0; r < 3; ++r) add_band(mesh, r * sides, sides, random);
  for (std::int32_t i = 1; i + 1 < sides; ++i) {
    add_triangle(mesh, 0, i + 1, i);
    add_triangle(mesh, 3 * sides, 3 * sides + i, 3 * sides + i + 1);
  }
  return mesh;
}

}  // namespace planish::quality
