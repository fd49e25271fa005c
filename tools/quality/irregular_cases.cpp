#include "quality/irregular_cases.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "make_scenes/bust.h"
#include "make_scenes/random_numbers.h"
#include "make_scenes/revolve.h"
#include "make_scenes/rocker_arm.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/repair.h"
#include "quality/irregular_shapes.h"

namespace planish::quality {

namespace {

constexpr bool kHeldOut = true;

// A closed shape around the origin: its distance from there by direction.
using Radius = std::function<double(const glm::dvec3&)>;

Radius ellipsoid(const glm::dvec3& axes) {
  return [axes](const glm::dvec3& d) { return 1 / glm::length(d / axes); };
}

double bumps(const glm::dvec3& d) { return 1 + 0.15 * std::sin(4 * d.x) * std::cos(3 * d.y + d.z); }

double fine_bumps(const glm::dvec3& d) {
  return 1 + 0.08 * std::sin(6 * d.x + 1) * std::sin(5 * d.y) * std::cos(4 * d.z);
}

// |x|^4 + |y|^4 + |z|^4 = 1.
double superquadric(const glm::dvec3& d) {
  const glm::dvec3 square = d * d;
  return 1 / std::sqrt(std::sqrt(glm::dot(square, square)));
}

// Two balls grown together.
double peanut(const glm::dvec3& d) { return 0.55 + 0.45 * d.x * d.x; }

// At random directions; `noise`: the radius is off by as much, deviation of a normal law, relative.
Case star(const Radius& radius, std::int32_t count, std::uint32_t seed, double noise = 0) {
  Case made;
  shapes::RandomNumbers random(seed + 1000);
  made.mesh = hull_of_directions(count, seed, [&](const glm::dvec3& d) {
    double sum = 0;  // of twelve even numbers: nearly normal, of deviation 1
    for (int i = 0; i < 12; ++i) sum += random.unit() - 0.5;
    return radius(d) * (1 + noise * sum) * d;
  });
  made.truth = true_zero_set([radius](const glm::dvec3& p) {
    const double length = glm::length(p);
    return length - radius(p / length);
  });
  return made;
}

// An ellipsoid's random points are even on the ball that it is stretched from.
Case stretched(const glm::dvec3& axes, std::int32_t count, std::uint32_t seed) {
  Case made;
  made.mesh = hull_of_directions(count, seed, [&](const glm::dvec3& d) { return axes * d; });
  made.truth = true_zero_set([axes](const glm::dvec3& p) {
    // About the distance.
    const glm::dvec3 scaled = p / axes;
    return (glm::length(scaled) - 1) * glm::length(scaled) / glm::length(scaled / axes);
  });
  return made;
}

using Height = std::function<double(double, double)>;

// Over the disc, which is stretched along x; open.
Case sheet(const Height& height, std::int32_t count, std::uint32_t seed, double stretch = 1) {
  Case made;
  const std::int32_t rim = static_cast<std::int32_t>(2 * std::sqrt(std::numbers::pi * count));
  made.mesh = sheet_over_disc(count, rim, seed, [&](const glm::dvec2& p) {
    const double x = stretch * p.x;
    return glm::dvec3(x, p.y, height(x, p.y));
  });
  made.truth = true_zero_set([height](const glm::dvec3& p) { return p.z - height(p.x, p.y); });
  return made;
}

Case ring(std::int32_t count, std::uint32_t seed, double tube_radius) {
  return {"", uneven_torus(count, seed, 1, tube_radius), true_torus(1, tube_radius)};
}

Case simplified_ring(double tube_radius, double tolerance) {
  const shapes::TorusOptions options{
      .ring_count = 300, .tube_count = 120, .radius = 1, .tube_radius = tube_radius};
  return {"", simplified_within(shapes::torus(options), tolerance), true_torus(1, tube_radius)};
}

// The dense mesh is the shape. `noise`: fraction of the diagonal by which what was simplified is
// off it.
Case simplified_scan(PolygonMesh dense, double tolerance, double noise = 0) {
  Case made;
  made.truth = true_mesh(dense);
  if (noise > 0) shapes::add_noise(dense.positions, noise * placement_of(dense).diagonal, 9);
  made.mesh = simplified_within(dense, tolerance);
  made.is_scan = true;
  return made;
}

PolygonMesh dense_bumps() {
  PolygonMesh mesh = shapes::icosphere(5);
  for (glm::dvec3& p : mesh.positions) p *= fine_bumps(p);
  return mesh;
}

}  // namespace

std::vector<NamedCase> irregular_cases() {
  std::vector<NamedCase> cases;
  const auto add = [&](const std::string& name, bool is_held_out,
                       const std::function<Case()>& make) {
    cases.push_back({name, [=] {
                       Case made = make();
                       made.name = name;
                       made.is_held_out = is_held_out;
                       return made;
                     }});
  };
  const Radius ball = ellipsoid(glm::dvec3(1));
  add("ball, 400", !kHeldOut, [=] { return star(ball, 400, 31); });
  add("ball, 1500", kHeldOut, [=] { return star(ball, 1500, 32); });
  add("egg, 2 : 1 : 0.6", !kHeldOut, [] { return stretched({2, 1, 0.6}, 600, 33); });
  add("egg, 1.5 : 1 : 1", kHeldOut, [] { return stretched({1.5, 1, 1}, 500, 34); });
  add("bumpy, 1500", !kHeldOut, [] { return star(bumps, 1500, 35); });
  add("bumpy, 4000", kHeldOut, [] { return star(fine_bumps, 4000, 36); });
  add("saddle, open", !kHeldOut,
      [] { return sheet([](double x, double y) { return 0.5 * (x * x - y * y); }, 500, 37); });
  add("monkey saddle, open", kHeldOut, [] {
    return sheet([](double x, double y) { return 0.4 * x * (x * x - 3 * y * y); }, 700, 38);
  });
  add("wave, open", kHeldOut, [] {
    return sheet([](double x, double y) { return 0.1 * std::sin(4 * x) * std::cos(3 * y); }, 900,
                 39);
  });
  add("torus, Delaunay", !kHeldOut, [] { return ring(600, 40, 0.4); });
  add("torus, simplified", kHeldOut, [] { return simplified_ring(0.4, 2e-3); });
  add("thin ring", kHeldOut, [] { return ring(900, 41, 0.1); });
  add("pancake, 1 : 1 : 0.12", !kHeldOut, [] { return stretched({1, 1, 0.12}, 1200, 42); });
  add("peanut", kHeldOut, [] { return star(peanut, 800, 43); });
  add("superquadric", kHeldOut, [] { return star(superquadric, 1000, 44); });
  add("needle, 5 : 1 : 1", !kHeldOut, [] { return stretched({5, 1, 1}, 1000, 45); });
  add("vault, 5 : 1, open", !kHeldOut, [] {
    return sheet([](double x, double y) { return 0.3 * std::cos(0.8 * x) - 0.4 * y * y; }, 600, 46,
                 5);
  });
  add("roof, 5 : 1 across, open", kHeldOut, [] {
    return sheet([](double x, double y) { return 0.4 * std::sin(1.2 * x) + 0.1 * y * y; }, 700, 47,
                 5);
  });
  add("ball, noise 0.2 %", !kHeldOut, [=] { return star(ball, 1500, 48, 2e-3); });
  add("bumpy, noise 0.1 %", kHeldOut, [] { return star(bumps, 2000, 49, 1e-3); });

  add("arm, simplified 1e-3", !kHeldOut,
      [] { return simplified_scan(shapes::rocker_arm(), 1e-3); });
  add("arm, noisy, simplified 2e-3", kHeldOut,
      [] { return simplified_scan(shapes::rocker_arm(), 2e-3, 2e-4); });
  add("bust, simplified 5e-4", !kHeldOut, [] { return simplified_scan(shapes::bust(), 5e-4); });
  add("bust, simplified 2e-3", kHeldOut, [] { return simplified_scan(shapes::bust(), 2e-3); });
  add("goblet, simplified 1e-3", kHeldOut, [] { return simplified_scan(shapes::goblet(), 1e-3); });
  add("knot, simplified 3e-3", !kHeldOut, [] { return simplified_scan(knot(500, 48), 3e-3); });
  add("knot, simplified 1e-3", kHeldOut, [] { return simplified_scan(knot(500, 48), 1e-3); });
  add("bumps, simplified 1e-3", !kHeldOut, [] { return simplified_scan(dense_bumps(), 1e-3); });
  return cases;
}

NamedCase simplified_file(const std::filesystem::path& path) {
  constexpr double kTolerance = 1e-3;
  const std::string name = path.filename().string();
  return {name, [=] {
            Case made = simplified_scan(repair(read_mesh(path).mesh).mesh, kTolerance);
            made.name = name;
            return made;
          }};
}

}  // namespace planish::quality
