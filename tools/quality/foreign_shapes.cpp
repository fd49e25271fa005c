#include "quality/foreign_shapes.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "make_scenes/random_numbers.h"
#include "make_scenes/shapes.h"
#include "planish/mesh/repair.h"
#include "planish/mesh/used_vertices.h"
#include "quality/random_sphere.h"
#include "quality/wild_shapes.h"

namespace planish::quality {

namespace {

using glm::dvec3;
using shapes::RandomNumbers;

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
