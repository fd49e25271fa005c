#include "support/outlines.h"

#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace planish::test {

using glm::dvec2;
using std::int32_t;
using std::numbers::pi;

namespace {

dvec2 unit_circle(double angle) { return {std::cos(angle), std::sin(angle)}; }

// From angle `start` on, both ends included.
void add_arc(Outline& outline, const dvec2& middle, double radius, double start, double turn,
             int steps) {
  for (int i = 0; i <= steps; ++i)
    outline.push_back(middle + radius * unit_circle(start + turn * i / steps));
}

}  // namespace

Outline rounded_square(int steps, double radius) {
  Outline outline;
  for (int corner = 0; corner < 4; ++corner) {
    const double start = pi / 2 * corner;
    const dvec2 middle = std::sqrt(2.0) * (1 - radius) * unit_circle(start + pi / 4);
    add_arc(outline, middle, radius, start, pi / 2, steps);
  }
  return outline;
}

Outline slot(int steps, double length) {
  Outline outline;
  add_arc(outline, {length, 0}, 1, -pi / 2, pi, steps);
  add_arc(outline, {-length, 0}, 1, pi / 2, pi, steps);
  return outline;
}

Outline pie_slice(int steps, double degrees) {
  Outline outline{{0, 0}};
  add_arc(outline, {0, 0}, 1, 0, degrees * pi / 180, steps);
  return outline;
}

Outline cam(int corners, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto drawn = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::array<dvec2, 8> waves;  // size, phase
  for (std::size_t k = 0; k < waves.size(); ++k) {
    waves[k].x = 0.25 * drawn() / static_cast<double>(k + 1);
    waves[k].y = 2 * pi * drawn();
  }
  Outline outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * pi * i / corners;
    double radius = 1;
    for (std::size_t k = 0; k < waves.size(); ++k)
      radius += waves[k].x * std::cos(static_cast<double>(k + 1) * angle + waves[k].y);
    outline.push_back(radius * unit_circle(angle));
  }
  return outline;
}

Outline gear_outline(int teeth, int steps) {
  Outline outline;
  for (int arc = 0; arc < 2 * teeth; ++arc)
    add_arc(outline, {0, 0}, arc % 2 == 0 ? 1.0 : 0.8, pi * arc / teeth, pi / teeth, steps);
  return outline;
}

PolygonMesh prism_over(const Outline& outline) {
  PolygonMesh mesh;
  const auto n = static_cast<int32_t>(outline.size());
  for (const double z : {1.0, -1.0})
    for (const dvec2& p : outline) mesh.positions.emplace_back(p, z);
  std::vector<int32_t> upper, lower;
  for (int32_t i = 0; i < n; ++i) {
    upper.push_back(i);
    lower.push_back(2 * n - 1 - i);
  }
  mesh.add_face(upper);
  mesh.add_face(lower);
  for (int32_t i = 0; i < n; ++i) {
    const int32_t next = (i + 1) % n;
    mesh.add_face(std::array{n + i, n + next, next, i});
  }
  return mesh;
}

PolygonMesh with_sharp_rims(PolygonMesh prism) {
  for (const int32_t cap : {0, 1}) {
    const auto corners = prism.face(cap);
    for (std::size_t i = 0; i < corners.size(); ++i)
      prism.creases.push_back({corners[i], corners[(i + 1) % corners.size()], kInfiniteSharpness});
  }
  return prism;
}

}  // namespace planish::test
