#include "make_scenes/revolve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "make_scenes/mesh_builder.h"

namespace planish::shapes {

namespace {

constexpr int kSamplesPerSpan = 200;

// Centripetal Catmull-Rom through the knots: no loops where long and short spans meet.
glm::dvec2 curve_point(std::span<const glm::dvec2> knots, std::size_t span, double t) {
  const glm::dvec2 p1 = knots[span];
  const glm::dvec2 p2 = knots[span + 1];
  const glm::dvec2 p0 = span > 0 ? knots[span - 1] : glm::dvec2(-p2.x, p2.y);
  const glm::dvec2 p3 = span + 2 < knots.size() ? knots[span + 2] : glm::dvec2(-p1.x, p1.y);
  const double t1 = std::sqrt(glm::distance(p0, p1));
  const double t2 = t1 + std::sqrt(glm::distance(p1, p2));
  const double t3 = t2 + std::sqrt(glm::distance(p2, p3));
  const double u = t1 + t * (t2 - t1);
  const auto mix = [u](glm::dvec2 a, glm::dvec2 b, double ta, double tb) {
    return a * ((tb - u) / (tb - ta)) + b * ((u - ta) / (tb - ta));
  };
  const glm::dvec2 a = mix(p0, p1, 0.0, t1);
  const glm::dvec2 b = mix(p1, p2, t1, t2);
  const glm::dvec2 c = mix(p2, p3, t2, t3);
  return mix(mix(a, b, 0.0, t2), mix(b, c, t1, t3), t1, t2);
}

std::vector<glm::dvec2> sampled(std::span<const glm::dvec2> knots) {
  std::vector<glm::dvec2> points;
  for (std::size_t span = 0; span + 1 < knots.size(); ++span) {
    for (int i = 0; i < kSamplesPerSpan; ++i) {
      points.push_back(curve_point(knots, span, static_cast<double>(i) / kSamplesPerSpan));
    }
  }
  points.push_back(knots.back());
  return points;
}

// How many rings a unit of length deserves at a sample: more on bends and thin parts.
double ring_density(std::span<const glm::dvec2> curve, std::size_t i) {
  constexpr double kFlatSpacing = 0.11;
  constexpr double kRadiansPerRing = 0.3;
  constexpr double kThinShare = 0.35;  // of the quad's width on a thin part
  constexpr std::size_t kReach = 60;   // samples over which the turn is measured
  const std::size_t low = i > kReach ? i - kReach : 0;
  const std::size_t high = std::min(i + kReach, curve.size() - 1);
  const glm::dvec2 before = curve[i] - curve[low];
  const glm::dvec2 after = curve[high] - curve[i];
  const double length = glm::length(before) + glm::length(after);
  const double turn =
      std::abs(std::atan2(before.x * after.y - before.y * after.x, glm::dot(before, after)));
  return 1.0 / kFlatSpacing + 2.0 * turn / length / kRadiansPerRing +
         kThinShare / (curve[i].x + 0.05);
}

std::vector<glm::dvec2> ring_points(std::span<const glm::dvec2> curve, std::int32_t count) {
  std::vector<double> weight(curve.size(), 0.0);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    weight[i] = weight[i - 1] + glm::distance(curve[i - 1], curve[i]) * ring_density(curve, i);
  }
  std::vector<glm::dvec2> rings;
  std::size_t i = 1;
  for (std::int32_t ring = 0; ring < count; ++ring) {
    const double target = weight.back() * ring / (count - 1);
    while (i + 1 < curve.size() && weight[i] < target) ++i;
    const double t = (target - weight[i - 1]) / (weight[i] - weight[i - 1]);
    rings.push_back(curve[i - 1] + (curve[i] - curve[i - 1]) * t);
  }
  return rings;
}

// Flat positions in the unit disc of a (side + 1)^2 grid whose border is on the circle's rim:
// smoothed with `kRings` rings around it, so that its corners open to 120 degrees.
struct Disc {
  std::vector<glm::dvec2> grid;                // (side + 1)^2, row by row
  std::vector<std::vector<glm::dvec2>> rings;  // from the grid's border outward, without it
};

// Grid index of the border's i-th vertex, counter-clockwise from (0, 0).
std::int32_t border_index(std::int32_t i, std::int32_t side) {
  const std::int32_t along = i % side;
  switch (i / side % 4) {
    case 0:
      return along;
    case 1:
      return along * (side + 1) + side;
    case 2:
      return side * (side + 1) + side - along;
    default:
      return (side - along) * (side + 1);
  }
}

constexpr std::int32_t kCapRings = 4;

Disc relaxed_disc(std::int32_t side) {
  constexpr int kSteps = 2000;
  const std::int32_t around = 4 * side;
  Disc disc;
  for (std::int32_t y = 0; y <= side; ++y) {
    for (std::int32_t x = 0; x <= side; ++x) {
      disc.grid.push_back((glm::dvec2(x, y) * (2.0 / side) - 1.0) * 0.5);
    }
  }
  for (std::int32_t ring = 1; ring <= kCapRings; ++ring) {
    auto& points = disc.rings.emplace_back();
    for (std::int32_t i = 0; i < around; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / around - 0.75 * std::numbers::pi;
      const glm::dvec2 rim(std::cos(angle), std::sin(angle));
      const double t = static_cast<double>(ring) / kCapRings;
      points.push_back(disc.grid[border_index(i, side)] * (1.0 - t) + rim * t);
    }
  }
  const auto ring_point = [&](std::int32_t ring, std::int32_t i) -> glm::dvec2& {
    i = (i + around) % around;
    return ring == 0 ? disc.grid[border_index(i, side)] : disc.rings[ring - 1][i];
  };
  for (int step = 0; step < kSteps; ++step) {
    for (std::int32_t y = 1; y < side; ++y) {
      for (std::int32_t x = 1; x < side; ++x) {
        const std::int32_t i = y * (side + 1) + x;
        disc.grid[i] = (disc.grid[i - 1] + disc.grid[i + 1] + disc.grid[i - side - 1] +
                        disc.grid[i + side + 1]) *
                       0.25;
      }
    }
    for (std::int32_t i = 0; i < around; ++i) {
      const bool is_corner = i % side == 0;
      glm::dvec2 sum = ring_point(0, i - 1) + ring_point(0, i + 1) + ring_point(1, i);
      if (!is_corner) {
        const std::int32_t inward = std::array{side + 1, -1, -side - 1, 1}[i / side];
        sum += disc.grid[border_index(i, side) + inward];
      }
      ring_point(0, i) = sum / (is_corner ? 3.0 : 4.0);
    }
    for (std::int32_t ring = 1; ring < kCapRings; ++ring) {
      for (std::int32_t i = 0; i < around; ++i) {
        ring_point(ring, i) = (ring_point(ring, i - 1) + ring_point(ring, i + 1) +
                               ring_point(ring - 1, i) + ring_point(ring + 1, i)) *
                              0.25;
      }
    }
  }
  return disc;
}

// Height of the curve's end part at a radius; `curve` runs from the axis outward.
double height_at(std::span<const glm::dvec2> curve, double radius) {
  std::size_t i = 1;
  while (i + 1 < curve.size() && curve[i].x < radius) ++i;
  const double t = (radius - curve[i - 1].x) / (curve[i].x - curve[i - 1].x);
  return curve[i - 1].y + t * (curve[i].y - curve[i - 1].y);
}

// Adds a disc inside the circle of vertices that starts at `rim`; the lower one faces down.
void add_cap(PolygonMesh& mesh, std::span<const glm::dvec2> curve, std::int32_t rim,
             const RevolveOptions& options, bool faces_down) {
  const std::int32_t side = options.segment_count / 4;
  const std::int32_t around = options.segment_count;
  const Disc disc = relaxed_disc(side);
  const auto add_vertex = [&](const glm::dvec2& flat) {
    const glm::dvec2 p = flat * options.cap_radius;
    mesh.positions.emplace_back(p.x, height_at(curve, glm::length(p)), -p.y);
  };
  const auto add_quad = [&](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    if (faces_down) {
      add_face(mesh, {d, c, b, a});
    } else {
      add_face(mesh, {a, b, c, d});
    }
  };
  const std::int32_t grid = mesh.vertex_count();
  for (const glm::dvec2& point : disc.grid) add_vertex(point);
  for (std::int32_t y = 0; y < side; ++y) {
    for (std::int32_t x = 0; x < side; ++x) {
      const std::int32_t a = grid + y * (side + 1) + x;
      add_quad(a, a + 1, a + side + 2, a + side + 1);
    }
  }
  const std::int32_t rings = mesh.vertex_count();
  for (std::int32_t ring = 0; ring + 1 < kCapRings; ++ring) {
    for (const glm::dvec2& point : disc.rings[ring]) add_vertex(point);
  }
  const auto vertex = [&](std::int32_t ring, std::int32_t i) {
    i %= around;
    if (ring == 0) return grid + border_index(i, side);
    return ring == kCapRings ? rim + i : rings + (ring - 1) * around + i;
  };
  for (std::int32_t ring = 0; ring < kCapRings; ++ring) {
    for (std::int32_t i = 0; i < around; ++i) {
      add_quad(vertex(ring, i), vertex(ring + 1, i), vertex(ring + 1, i + 1), vertex(ring, i + 1));
    }
  }
}

}  // namespace

PolygonMesh revolve(std::span<const glm::dvec2> profile, const RevolveOptions& options) {
  const std::int32_t around = options.segment_count;
  if (around < 8 || around % 4 != 0 || options.ring_count < 2 * kCapRings) {
    throw std::invalid_argument("revolve: segments a multiple of 4 from 8, at least 8 rings");
  }
  const std::vector<glm::dvec2> curve = sampled(profile);
  const auto is_beyond_cap = [&](const glm::dvec2& p) { return p.x >= options.cap_radius; };
  const auto first = std::find_if(curve.begin(), curve.end(), is_beyond_cap);
  const auto last = std::find_if(curve.rbegin(), curve.rend(), is_beyond_cap).base();
  // The caps hold rings of their own.
  const std::int32_t ring_count = options.ring_count - 2 * (kCapRings - 1);
  std::vector<glm::dvec2> rings = ring_points(std::span(first, last), ring_count);
  PolygonMesh mesh;
  for (glm::dvec2& ring : rings) {
    if (&ring == &rings.front() || &ring == &rings.back()) ring.x = options.cap_radius;
    for (std::int32_t i = 0; i < around; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / around - 0.75 * std::numbers::pi;
      mesh.positions.emplace_back(ring.x * std::cos(angle), ring.y, -ring.x * std::sin(angle));
    }
  }
  for (std::int32_t ring = 0; ring + 1 < ring_count; ++ring) {
    for (std::int32_t i = 0; i < around; ++i) {
      const std::int32_t a = ring * around + i;
      const std::int32_t b = ring * around + (i + 1) % around;
      add_face(mesh, {a, b, b + around, a + around});
    }
  }
  add_cap(mesh, curve, 0, options, true);
  const std::vector<glm::dvec2> reversed(curve.rbegin(), curve.rend());
  add_cap(mesh, reversed, (ring_count - 1) * around, options, false);
  return mesh;
}

PolygonMesh goblet() {
  constexpr std::array<glm::dvec2, 37> kProfile{{
      {0.0, 0.10},   {0.30, 0.09},  {0.62, 0.03},  {0.76, 0.0},    // hollow under the foot
      {0.82, 0.02},  {0.82, 0.06},  {0.74, 0.09},                  // its rim
      {0.56, 0.13},  {0.36, 0.20},  {0.21, 0.34},  {0.135, 0.55},  // the foot rises to the stem
      {0.11, 0.78},  {0.115, 0.92}, {0.17, 0.97},  {0.225, 1.05},  // knop
      {0.17, 1.13},  {0.115, 1.18}, {0.11, 1.32},  {0.14, 1.46},   // stem
      {0.26, 1.57},  {0.50, 1.70},  {0.72, 1.92},  {0.85, 2.22},   // bowl, outside
      {0.89, 2.55},  {0.87, 2.90},  {0.82, 3.20},  {0.785, 3.38},  //
      {0.762, 3.41}, {0.74, 3.38},                                 // lip
      {0.77, 3.20},  {0.82, 2.90},  {0.838, 2.55}, {0.80, 2.25},   // bowl, inside
      {0.68, 1.98},  {0.46, 1.79},  {0.22, 1.70},  {0.0, 1.68},    //
  }};
  RevolveOptions options;
  options.cap_radius = 0.24;
  return revolve(kProfile, options);
}

}  // namespace planish::shapes
