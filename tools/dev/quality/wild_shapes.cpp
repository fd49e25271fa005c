#include "quality/wild_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "make_scenes/implicit.h"
#include "make_scenes/models.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"
#include "planish/mend/repair.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish::quality {

std::vector<glm::dvec3> random_sphere_points(std::int32_t count, std::uint32_t seed) {
  shapes::RandomNumbers random(seed);
  std::vector<glm::dvec3> points;
  for (std::int32_t i = 0; i < count; ++i) {
    const double z = 2 * random.unit() - 1, angle = 2 * std::numbers::pi * random.unit();
    const double radius = std::sqrt(1 - z * z);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return points;
}

std::vector<Triangle> delaunay_on_sphere(const std::vector<glm::dvec3>& points) {
  const auto sees = [&](const glm::dvec3& p, const Triangle& t) {
    const glm::dvec3& origin = points[t[0]];
    return glm::dot(glm::cross(points[t[1]] - origin, points[t[2]] - origin), p - origin) > 0;
  };
  std::vector<Triangle> hull{{0, 1, 2}, {0, 2, 1}};
  // Every further point lies outside: what it sees gives way to a fan around the rim.
  for (std::int32_t p = 3; p < static_cast<std::int32_t>(points.size()); ++p) {
    std::set<std::pair<std::int32_t, std::int32_t>> rim;
    std::erase_if(hull, [&](const Triangle& t) {
      if (!sees(points[p], t)) return false;
      for (int k = 0; k < 3; ++k) {
        const std::int32_t a = t[k], b = t[(k + 1) % 3];
        if (rim.erase({b, a}) == 0) rim.insert({a, b});
      }
      return true;
    });
    for (const auto& [a, b] : rim) hull.push_back({a, b, p});
  }
  return hull;
}

namespace {

constexpr double kRound = 2 * std::numbers::pi;

// Circles of the plane are circles of the sphere, so that the hull of the points on it and of the
// pole, left out again, is Delaunay's triangulation. Counter-clockwise.
std::vector<Triangle> delaunay_in_plane(std::span<const glm::dvec2> points) {
  std::vector<glm::dvec3> on_sphere;
  for (const glm::dvec2& p : points) {
    const double square = glm::dot(p, p);
    on_sphere.emplace_back(glm::dvec3(2 * p.x, 2 * p.y, square - 1) / (square + 1));
  }
  const auto pole = static_cast<std::int32_t>(on_sphere.size());
  on_sphere.emplace_back(0, 0, 1);
  std::vector<Triangle> triangles = delaunay_on_sphere(on_sphere);
  std::erase_if(triangles, [&](const Triangle& t) { return std::ranges::count(t, pole) > 0; });
  // From outside the sphere the plane is seen from below.
  for (Triangle& t : triangles) std::swap(t[1], t[2]);
  return triangles;
}

}  // namespace

PolygonMesh hull_of_directions(std::int32_t count, std::uint32_t seed,
                               const std::function<glm::dvec3(const glm::dvec3&)>& map) {
  std::vector<glm::dvec3> points = random_sphere_points(count, seed);
  PolygonMesh mesh = polygons_of(delaunay_on_sphere(points));
  for (glm::dvec3& p : points) p = map(p);
  mesh.positions = std::move(points);
  return mesh;
}

PolygonMesh sheet_over_disc(std::int32_t inner, std::int32_t rim, std::uint32_t seed,
                            const std::function<glm::dvec3(const glm::dvec2&)>& map) {
  constexpr double kInside = 0.97;
  shapes::RandomNumbers random(seed);
  std::vector<glm::dvec2> points;
  for (std::int32_t i = 0; i < inner; ++i) {
    const double radius = kInside * std::sqrt(random.unit()), angle = kRound * random.unit();
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  for (std::int32_t i = 0; i < rim; ++i) {
    const double angle = kRound * (i + 0.35 * random.sway()) / rim;
    points.emplace_back(std::cos(angle), std::sin(angle));
  }
  PolygonMesh mesh = polygons_of(delaunay_in_plane(points));
  for (const glm::dvec2& p : points) mesh.positions.push_back(map(p));
  return mesh;
}

PolygonMesh uneven_torus(std::int32_t count, std::uint32_t seed, double radius,
                         double tube_radius) {
  shapes::RandomNumbers random(seed);
  // Unrolled, and its eight neighbours; as small as the plane's part that the sphere shows well.
  const glm::dvec2 size(1, tube_radius / radius);
  std::vector<glm::dvec2> points;
  for (std::int32_t i = 0; i < count; ++i) {
    const double x = random.unit(), y = random.unit();
    points.push_back(size * glm::dvec2(x, y));
  }
  const std::vector<glm::dvec2> own = points;
  for (const double dx : {-1, 0, 1})
    for (const double dy : {-1, 0, 1})
      if (dx != 0 || dy != 0)
        for (const glm::dvec2& p : own) points.push_back(p + size * glm::dvec2(dx, dy));
  std::vector<glm::dvec2> centred = points;
  for (glm::dvec2& p : centred) p -= 0.5 * size;
  PolygonMesh mesh;
  for (const Triangle& t : delaunay_in_plane(centred)) {
    const glm::dvec2 middle = (points[t[0]] + points[t[1]] + points[t[2]]) / 3.0;
    if (middle.x < 0 || middle.x >= size.x || middle.y < 0 || middle.y >= size.y) continue;
    mesh.add_face(std::array{t[0] % count, t[1] % count, t[2] % count});
  }
  for (const glm::dvec2& p : own) {
    const double u = kRound * p.x, v = kRound * p.y / size.y;
    const double r = radius + tube_radius * std::cos(v);
    mesh.positions.emplace_back(r * std::cos(u), r * std::sin(u), tube_radius * std::sin(v));
  }
  return mesh;
}

PolygonMesh knot(std::int32_t along, std::int32_t around) {
  constexpr double kTube = 0.45;
  PolygonMesh mesh;
  const auto centre = [](double t) {
    return glm::dvec3(std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t),
                      -std::sin(3 * t));
  };
  for (std::int32_t i = 0; i < along; ++i) {
    const double t = kRound * i / along, step = 1e-4;
    const glm::dvec3 tangent = glm::normalize(centre(t + step) - centre(t - step));
    // The knot lies around a torus: what points away from its middle is never along it.
    const glm::dvec3 c = centre(t);
    const glm::dvec3 out = glm::dvec3(c.x, c.y, 0);
    const glm::dvec3 e1 = glm::normalize(out - glm::dot(out, tangent) * tangent);
    const glm::dvec3 e2 = glm::cross(tangent, e1);
    for (std::int32_t j = 0; j < around; ++j) {
      const double angle = kRound * j / around;
      mesh.positions.push_back(c + kTube * (std::cos(angle) * e1 + std::sin(angle) * e2));
      const std::int32_t next = (i + 1) % along, up = (j + 1) % around;
      mesh.add_face(
          std::array{around * i + j, around * i + up, around * next + up, around * next + j});
    }
  }
  return mesh;
}

PolygonMesh simplified_within(const PolygonMesh& dense, double tolerance) {
  std::vector<Triangle> triangles;
  for (std::int32_t f = 0; f < dense.face_count(); ++f) {
    const auto face = dense.face(f);
    std::vector<std::uint32_t> cut(3 * (face.size() - 2));
    std::vector<glm::dvec3> corners;
    for (const std::int32_t v : face) corners.push_back(dense.positions[v]);
    std::vector<std::int32_t> numbers(face.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int32_t>(i);
    triangulate(numbers, corners, cut);
    for (std::size_t i = 0; i < cut.size(); i += 3)
      triangles.push_back({face[cut[i]], face[cut[i + 1]], face[cut[i + 2]]});
  }
  const SimplifiedMesh simplified =
      simplify(dense.positions, triangles, {.tolerance = tolerance * placement_of(dense).diagonal});
  PolygonMesh mesh = polygons_of(simplified.triangles);
  mesh.positions = dense.positions;
  return without_unused_vertices(mesh).mesh;
}

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

namespace {

constexpr double kLoftTurn = 2 * std::numbers::pi;

struct LoftRing {
  std::int32_t first, count;
};

// An ellipse whose second axis is `flat` times its first, turned by `start` of its parameter.
LoftRing add_ellipse(PolygonMesh& mesh, std::int32_t count, double radius, double flat, double z,
                     double start) {
  const LoftRing ring{mesh.vertex_count(), count};
  for (std::int32_t i = 0; i < count; ++i) {
    const double angle = kLoftTurn * i / count + start;
    mesh.positions.emplace_back(radius * std::cos(angle), flat * radius * std::sin(angle), z);
  }
  return ring;
}

// Triangles between two rings, ahead on the one that is behind.
void add_loft_band(PolygonMesh& mesh, const LoftRing& low, const LoftRing& high) {
  for (std::int32_t i = 0, j = 0; i < low.count || j < high.count;) {
    const std::int32_t a = low.first + i % low.count, b = high.first + j % high.count;
    if (j >= high.count || (i < low.count && (i + 1) * high.count <= (j + 1) * low.count)) {
      mesh.add_face(std::array{a, low.first + ++i % low.count, b});
    } else {
      mesh.add_face(std::array{a, high.first + ++j % high.count, b});
    }
  }
}

}  // namespace

PolygonMesh flat_loft(std::int32_t sides, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh;
  const LoftRing bottom = add_ellipse(mesh, sides, 2, 0.1, 0, 0);
  const LoftRing neck = add_ellipse(mesh, sides, 0.4, 1, 4, 1 + 0.4 * random.unit());
  const LoftRing top = add_ellipse(mesh, 2 * sides + 2, 1.5, 0.3, 4.3, 0);
  add_loft_band(mesh, bottom, neck);
  add_loft_band(mesh, neck, top);
  for (std::int32_t i = 1; i + 1 < bottom.count; ++i)
    mesh.add_face(std::array{bottom.first, bottom.first + i + 1, bottom.first + i});
  for (std::int32_t i = 1; i + 1 < top.count; ++i)
    mesh.add_face(std::array{top.first, top.first + i, top.first + i + 1});
  return mesh;
}

PolygonMesh torn_sheet(std::int32_t spokes, std::int32_t rings, std::uint32_t seed) {
  RandomNumbers random(seed);
  const auto sway = [&] { return 2 * random.unit() - 1; };
  constexpr double kGap = 14 * std::numbers::pi / 180;
  PolygonMesh mesh;
  mesh.positions.emplace_back(0.0, 0.0, 0.0);
  const double step = (kLoftTurn - kGap) / spokes;
  for (std::int32_t r = 1; r <= rings; ++r) {
    for (std::int32_t i = 0; i <= spokes; ++i) {
      const bool is_lip = i == 0 || i == spokes;
      const double angle = kGap / 2 + step * (i + (is_lip ? 0 : 0.25 * sway()));
      const double slope = 1 - 1.6 * i / spokes + 0.3 * std::sin(3 * angle);
      mesh.positions.emplace_back(r * std::cos(angle), r * std::sin(angle),
                                  r * slope + 0.05 * sway());
    }
  }
  for (std::int32_t i = 0; i < spokes; ++i) mesh.add_face(std::array{0, 1 + i, 2 + i});
  for (std::int32_t r = 0; r + 1 < rings; ++r) {
    for (std::int32_t i = 0; i < spokes; ++i) {
      const std::int32_t a = 1 + r * (spokes + 1) + i, b = a + 1, c = b + spokes + 1,
                         d = a + spokes + 1;
      const bool other = random.below(2) == 0;
      mesh.add_face(other ? std::array{a, d, c} : std::array{a, d, b});
      mesh.add_face(other ? std::array{a, c, b} : std::array{d, c, b});
    }
  }
  return mesh;
}

namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;

PolygonMesh sound(const PolygonMesh& mesh) {
  return without_unused_vertices(repair(mesh).mesh).mesh;
}

void append(PolygonMesh& mesh, const PolygonMesh& part) {
  const std::int32_t first = mesh.vertex_count();
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  std::vector<std::int32_t> corners;
  for (std::int32_t f = 0; f < part.face_count(); ++f) {
    corners.clear();
    for (const std::int32_t v : part.face(f)) corners.push_back(first + v);
    mesh.add_face(corners);
  }
}

// Two fans about hubs and a band of needles between, their angles by lot.
PolygonMesh drum(std::int32_t sides, double radius, double height, RandomNumbers& random) {
  PolygonMesh mesh;
  for (const double z : {-height / 2, height / 2}) {
    for (std::int32_t i = 0; i < sides; ++i) {
      const double angle = kWholeTurn * (i + 0.45 * random.sway()) / sides;
      mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  mesh.positions.emplace_back(0.3 * radius, 0.2 * radius, -height / 2);
  mesh.positions.emplace_back(-0.4 * radius, 0.1 * radius, height / 2);
  for (std::int32_t i = 0; i < sides; ++i) {
    const std::int32_t next = (i + 1) % sides;
    mesh.add_face(std::array{i, next, sides + next});
    mesh.add_face(std::array{i, sides + next, sides + i});
    mesh.add_face(std::array{next, i, 2 * sides});
    mesh.add_face(std::array{sides + i, sides + next, 2 * sides + 1});
  }
  return mesh;
}

dvec3 upright(const dvec3& direction) {
  return glm::normalize(
      glm::cross(direction, std::abs(direction.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0)));
}

}  // namespace

PolygonMesh crossing_parts(std::int32_t sides, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh = drum(sides, 0.5, 2.5, random);
  PolygonMesh across = drum(sides + 7, 0.35, 2, random);
  for (dvec3& p : across.positions) p = dvec3(p.z, p.x + 0.1, p.y + 0.2);
  PolygonMesh ball = shapes::pole_sphere(sides, 6);
  const dvec3 middle(0.2, -0.1, 0.6 + 0.1 * random.sway());
  for (dvec3& p : ball.positions) p = 0.7 * p + middle;
  append(mesh, across);
  append(mesh, ball);
  return sound(mesh);
}

PolygonMesh touching_tori(std::int32_t around, std::int32_t count, std::uint32_t seed) {
  RandomNumbers random(seed);
  constexpr std::int32_t kAcross = 8;
  PolygonMesh mesh;
  const double radius = 0.5 + 0.2 * random.unit();
  // Ring kAcross / 4 of one torus is the ring below of the next.
  std::vector<std::int32_t> shared(static_cast<std::size_t>(around), -1), top = shared;
  for (std::int32_t torus = 0; torus < count; ++torus) {
    std::vector<std::int32_t> numbers;
    for (std::int32_t i = 0; i < around; ++i) {
      for (std::int32_t j = 0; j < kAcross; ++j) {
        const double a = kWholeTurn * i / around, b = kWholeTurn * j / kAcross;
        if (j == 3 * kAcross / 4 && shared[i] >= 0) {
          numbers.push_back(shared[i]);
          continue;
        }
        const double reach = 2 + radius * std::cos(b) * (1 + 0.1 * std::sin(3 * a + torus));
        numbers.push_back(mesh.vertex_count());
        mesh.positions.emplace_back(reach * std::cos(a), reach * std::sin(a),
                                    radius * (std::sin(b) + 2 * torus));
        if (j == kAcross / 4) top[i] = numbers.back();
      }
    }
    for (std::int32_t i = 0; i < around; ++i) {
      for (std::int32_t j = 0; j < kAcross; ++j) {
        const std::int32_t in = (i + 1) % around, jn = (j + 1) % kAcross;
        mesh.add_face(std::array{numbers[i * kAcross + j], numbers[in * kAcross + j],
                                 numbers[in * kAcross + jn], numbers[i * kAcross + jn]});
      }
    }
    std::swap(shared, top);
  }
  return sound(mesh);
}

PolygonMesh loose_sheets(std::int32_t count, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh mesh;
  const std::vector<dvec3> places = random_sphere_points(count, seed);
  for (const dvec3& place : places) {
    const dvec3 along = upright(place), left = glm::cross(place, along);
    const double size = 1.5 / std::sqrt(count) * (0.3 + random.unit());
    const std::int32_t faces = 1 + random.below(6), first = mesh.vertex_count();
    // A fan of triangles, or a strip of quads.
    const bool is_fan = random.below(2) == 0;
    if (is_fan) mesh.positions.push_back(place);
    for (std::int32_t i = 0; i <= faces; ++i) {
      const double angle = (i + 0.3 * random.sway()) * kWholeTurn / 9;
      const dvec3 across = std::cos(angle) * along + std::sin(angle) * left;
      const dvec3 rise = 0.3 * random.sway() * place;
      mesh.positions.push_back(place + size * (across + rise));
      if (!is_fan) mesh.positions.push_back(place + size * (0.4 * across + rise));
      if (i == 0) continue;
      if (is_fan)
        mesh.add_face(std::array{first, first + i, first + i + 1});
      else
        mesh.add_face(
            std::array{first + 2 * i - 1, first + 2 * i - 2, first + 2 * i, first + 2 * i + 1});
    }
  }
  return sound(mesh);
}

PolygonMesh pinched_polygons(std::int32_t count, std::uint32_t seed) {
  RandomNumbers random(seed);
  PolygonMesh triangles;
  triangles.positions = random_sphere_points(count, seed);
  for (const Triangle& t : delaunay_on_sphere(triangles.positions)) triangles.add_face(t);
  PolygonMesh mesh = shapes::dual(triangles);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    if (face.size() < 6 || random.below(2) == 0) continue;
    dvec3 &a = mesh.positions[face[0]], &b = mesh.positions[face[face.size() / 2]];
    const dvec3 middle = 0.5 * (a + b);
    a = middle + 0.1 * (a - middle);
    b = middle + 0.1 * (b - middle);
  }
  return sound(mesh);
}

PolygonMesh holed_scan(std::int32_t points, std::uint32_t seed) {
  RandomNumbers random(seed);
  constexpr int kGaps = 9;
  std::vector<dvec3> gaps = random_sphere_points(kGaps, seed + 1);
  std::vector<double> sizes;
  for (int i = 0; i < kGaps; ++i) sizes.push_back(0.08 + 0.25 * random.unit());
  PolygonMesh mesh;
  const std::vector<dvec3> places = random_sphere_points(points, seed);
  for (const dvec3& p : places) {
    const double bumps =
        0.12 * std::sin(5 * p.x + 1) * std::cos(4 * p.y) + 0.08 * std::sin(6 * p.z);
    mesh.positions.push_back((1 + bumps + 1e-3 * random.sway()) * p);
  }
  for (const Triangle& t : delaunay_on_sphere(places)) {
    const dvec3 middle = glm::normalize(places[t[0]] + places[t[1]] + places[t[2]]);
    bool is_seen = true;
    for (int i = 0; i < kGaps; ++i)
      if (glm::distance(middle, gaps[i]) < sizes[i] * (1 + 0.2 * std::sin(40 * middle.x)))
        is_seen = false;
    if (is_seen) mesh.add_face(t);
  }
  return simplified(sound(mesh), 1e-3);
}

}  // namespace planish::quality
