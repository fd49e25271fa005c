#include "quality/loft_shapes.h"

#include <array>
#include <cmath>
#include <numbers>

#include "make_scenes/random_numbers.h"

namespace planish::quality {

namespace {

using glm::dvec3;
using shapes::RandomNumbers;

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

}  // namespace planish::quality
