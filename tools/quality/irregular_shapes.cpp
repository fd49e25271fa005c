#include "quality/irregular_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "make_scenes/random_numbers.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/triangle_edges.h"
#include "planish/mesh/triangulate.h"
#include "planish/mesh/used_vertices.h"
#include "planish/reconstruct/simplify.h"
#include "quality/random_sphere.h"

namespace planish::quality {

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

}  // namespace planish::quality
