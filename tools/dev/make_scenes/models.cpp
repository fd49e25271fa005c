#include "make_scenes/models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "make_scenes/implicit.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/shapes.h"
#include "planish/core/portable_math.h"
#include "planish/reconstruct/reconstruct.h"

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
      std::abs(portable::atan2(before.x * after.y - before.y * after.x, glm::dot(before, after)));
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
      const glm::dvec2 rim(portable::cos(angle), portable::sin(angle));
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
      mesh.positions.emplace_back(ring.x * portable::cos(angle), ring.y,
                                  -ring.x * portable::sin(angle));
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

namespace {

constexpr double kRounding = 0.06;  // of outer edges
constexpr double kFillet = 0.14;    // between bodies

constexpr glm::dvec2 kRodEnd(-1.45, 0.16);
constexpr glm::dvec2 kValveEnd(1.42, -0.20);

// Plane figure: the disc swept from the hub to an end.
double arm_outline(const glm::dvec2& p, const glm::dvec2& end, double hub_radius,
                   double end_radius) {
  const double t = std::clamp(glm::dot(p, end) / glm::dot(end, end), 0.0, 1.0);
  return glm::distance(p, end * t) - (hub_radius + (end_radius - hub_radius) * t);
}

// Arm with a pocket on either side, which leaves a web and a rib around it.
double ribbed_arm(const glm::dvec3& p, const glm::dvec2& end, double hub_radius,
                  double end_radius) {
  constexpr double kHalfWidth = 0.27;
  constexpr double kHalfWeb = 0.10;
  constexpr double kRib = 0.13;
  const double outline = arm_outline(glm::dvec2(p), end, hub_radius, end_radius);
  const double body = extruded(outline, p.z, kHalfWidth, kRounding);
  const double pocket =
      extruded(outline + kRib, std::abs(p.z) - kHalfWidth, kHalfWidth - kHalfWeb, kRounding);
  return smooth_difference(body, pocket, kRounding);
}

}  // namespace

double rocker_arm_field(const glm::dvec3& p) {
  // Hub and its bore, along z.
  const double hub_distance = glm::length(glm::dvec2(p));
  const double hub = extruded(hub_distance - 0.54, p.z, 0.56, kRounding);
  // Upright boss at the push rod's end, with its socket from above.
  const glm::dvec3 rod = p - glm::dvec3(kRodEnd, 0.0);
  const double rod_distance = glm::length(glm::dvec2(rod.x, rod.z));
  const double boss = extruded(rod_distance - 0.34, rod.y - 0.04, 0.46, kRounding);
  const double socket = Cone{{0.0, 0.2, 0.0}, {0.0, 0.8, 0.0}, 0.17, 0.17}(rod);
  // Pad: a drum across the arm, with a foot below it that rolls on the valve stem.
  const glm::dvec3 valve = p - glm::dvec3(kValveEnd, 0.0);
  const double drum = extruded(glm::length(glm::dvec2(valve)) - 0.25, valve.z, 0.33, kRounding);
  const double foot = extruded(glm::length(glm::dvec2(valve) - glm::dvec2(0.02, 0.16)) - 0.50,
                               valve.z, 0.25, kRounding);
  const double foot_block =
      rounded_box(valve - glm::dvec3(0.03, -0.16, 0.0), {0.22, 0.22, 0.27}, kRounding);
  const double pad = smooth_union(drum, smooth_intersection(foot, foot_block, 0.06), 0.08);

  double body = smooth_union(ribbed_arm(p, kRodEnd * 0.84, 0.44, 0.25),
                             ribbed_arm(p, kValveEnd * 0.90, 0.44, 0.19), 0.08);
  body = smooth_union(body, hub, kFillet);
  body = smooth_union(body, boss, kFillet);
  body = smooth_union(body, pad, kFillet);
  body = smooth_difference(body, hub_distance - 0.32, kRounding);
  return smooth_difference(body, socket, kRounding);
}

PolygonMesh rocker_arm() {
  SurfaceNetsOptions options;
  // Off the planes of symmetry by odd amounts: no lattice point lies on a flat side.
  options.low = {-1.9713, -0.9117, -0.6619};
  options.high = {1.95, 0.85, 0.66};
  options.cell = 0.0363;
  return surface_nets(rocker_arm_field, options);
}

namespace {

double skull(const glm::dvec3& p) {
  double head = Ellipsoid{{0.0, 0.16, -0.08}, {0.43, 0.47, 0.53}}(p);
  head = smooth_union(head, Ellipsoid{{0.0, -0.16, 0.10}, {0.335, 0.43, 0.365}}(p), 0.15);
  head = smooth_union(head, Cone{{0.0, -0.41, 0.22}, {0.22, -0.30, 0.0}, 0.14, 0.13}(p), 0.12);
  head = smooth_union(head, Ellipsoid{{0.0, -0.50, 0.31}, {0.14, 0.095, 0.115}}(p), 0.10);
  head = smooth_union(head, Ellipsoid{{0.2, -0.10, 0.29}, {0.13, 0.11, 0.13}}(p), 0.10);
  return smooth_union(head, Ellipsoid{{0.0, 0.30, 0.22}, {0.27, 0.20, 0.215}}(p), 0.12);
}

double with_eyes(double head, const glm::dvec3& p) {
  const double brow = Cone{{0.045, 0.075, 0.455}, {0.26, 0.145, 0.335}, 0.055, 0.045}(p);
  head = smooth_union(head, brow, 0.05);
  head = smooth_difference(head, Ellipsoid{{0.16, 0.0, 0.50}, {0.105, 0.075, 0.12}}(p), 0.06);
  const double ball = Ellipsoid{{0.155, -0.005, 0.355}, {0.088, 0.08, 0.088}}(p);
  head = smooth_union(head, ball, 0.02);
  const double upper_lid = Cone{{0.085, 0.03, 0.425}, {0.225, 0.025, 0.385}, 0.026, 0.026}(p);
  const double lower_lid = Cone{{0.09, -0.06, 0.415}, {0.22, -0.055, 0.38}, 0.02, 0.02}(p);
  head = smooth_union(head, upper_lid, 0.04);
  return smooth_union(head, lower_lid, 0.03);
}

double with_nose(double head, const glm::dvec3& p) {
  const double bridge = Cone{{0.0, 0.10, 0.445}, {0.0, -0.10, 0.555}, 0.036, 0.062}(p);
  head = smooth_union(head, bridge, 0.05);
  head = smooth_union(head, Ellipsoid{{0.0, -0.115, 0.565}, {0.06, 0.055, 0.055}}(p), 0.03);
  return smooth_union(head, Ellipsoid{{0.058, -0.128, 0.50}, {0.042, 0.042, 0.06}}(p), 0.035);
}

double with_mouth(double head, const glm::dvec3& p) {
  head = smooth_union(head, Ellipsoid{{0.0, -0.295, 0.345}, {0.17, 0.125, 0.11}}(p), 0.06);
  const double upper_lip = Cone{{0.0, -0.252, 0.440}, {0.12, -0.292, 0.375}, 0.042, 0.024}(p);
  const double lower_lip = Cone{{0.0, -0.345, 0.428}, {0.095, -0.338, 0.385}, 0.048, 0.032}(p);
  head = smooth_union(head, upper_lip, 0.03);
  head = smooth_union(head, lower_lip, 0.03);
  const double gap = Cone{{0.0, -0.297, 0.487}, {0.15, -0.312, 0.405}, 0.016, 0.012}(p);
  head = smooth_difference(head, gap, 0.04);
  const double below = Cone{{0.0, -0.412, 0.485}, {0.08, -0.408, 0.445}, 0.03, 0.02}(p);
  return smooth_difference(head, below, 0.06);
}

}  // namespace

double bust_face(const glm::dvec3& p) {
  const glm::dvec3 half(std::abs(p.x), p.y, p.z);  // both sides alike
  double head = skull(half);
  head = with_eyes(head, half);
  head = with_nose(head, half);
  head = with_mouth(head, half);
  double ear = Ellipsoid{{0.425, -0.03, -0.02}, {0.05, 0.13, 0.085}}(half);
  ear = smooth_difference(ear, Ellipsoid{{0.48, -0.02, 0.0}, {0.035, 0.07, 0.045}}(half), 0.03);
  return smooth_union(head, ear, 0.04);
}

namespace {

constexpr glm::dvec3 kScalpCentre(0.0, 0.17, -0.10);
constexpr glm::dvec3 kScalpRadii(0.485, 0.52, 0.57);

// Negative where hair grows: behind a plane from the forehead down past the ears.
double hairline(const glm::dvec3& p) { return -0.44 * (p.y - 0.43) + 0.9 * (p.z - 0.36); }

// Waves combed back all around from the middle of the face: height over the scalp.
double waves(const glm::dvec3& p) {
  constexpr double kWaveCount = 15.0;
  constexpr double kHeight = 0.064;
  const glm::dvec3 direction = glm::normalize(p - kScalpCentre);
  // Angle from the pole of the waves, and around it; the pole lies in the face, its opposite below
  // the back of the head.
  constexpr glm::dvec3 kPole(0.0, 0.1, 0.994987437106620);
  constexpr glm::dvec3 kUp(0.0, 0.994987437106620, -0.1);
  const double away = portable::acos(std::clamp(glm::dot(direction, kPole), -1.0, 1.0));
  const double around = portable::atan2(direction.x, glm::dot(direction, kUp));
  const double strand = kWaveCount * around + 1.6 * portable::sin(4.5 * away + 2.0 * around) +
                        0.8 * portable::sin(3.0 * around + 1.0);
  const double curl = 0.75 + 0.25 * portable::sin(8.0 * away + 1.5 * portable::sin(5.0 * around));
  const double fade = smooth_step(0.3, 0.9, away) * smooth_step(2.95, 2.25, away);
  return kHeight * fade * curl * (0.5 + 0.5 * portable::cos(strand));
}

bool grows_hair(const glm::dvec3& p) {
  const bool is_by_the_ear = std::abs(p.x) > 0.3 && p.y < 0.10 && p.z > -0.14;
  return hairline(p) < 0.0 && hairline(p) > -0.20 && p.y > -0.42 && !is_by_the_ear;
}

glm::dvec3 turned(const glm::dvec3& v, const glm::dvec3& axis, double angle) {
  return v * portable::cos(angle) + glm::cross(axis, v) * portable::sin(angle) +
         axis * (glm::dot(axis, v) * (1.0 - portable::cos(angle)));
}

// Combed back from the forehead, disordered, each curling to one side with its tip off the head.
Lock lock_at(const glm::dvec3& direction, RandomNumbers& random) {
  constexpr int kPoints = 6;
  const glm::dvec3 comb(0.3 * direction.x, -0.45, -1.0);
  const double stray = 1.5 * (random.unit() - 0.5);
  const double curl = (random.unit() < 0.5 ? -1.0 : 1.0) * (0.15 + 0.35 * random.unit());
  const double step = 0.065 + 0.03 * random.unit();
  const double thickness = 0.075 + 0.03 * random.unit();
  const double lift = 0.01 + 0.035 * random.unit();
  Lock lock;
  glm::dvec3 outward = direction;
  glm::dvec3 heading = turned(comb - outward * glm::dot(comb, outward), outward, stray);
  heading = glm::normalize(heading);
  for (int i = 0; i < kPoints; ++i) {
    const double along = static_cast<double>(i) / (kPoints - 1);
    lock.points.push_back(kScalpCentre + outward * kScalpRadii +
                          outward * (lift - 0.09 * along * along));
    lock.radii.push_back(thickness * (1.0 - 0.4 * (2.0 * along - 0.8) * (2.0 * along - 0.8)));
    outward = glm::normalize(outward + heading * (step / 0.5));
    heading =
        turned(heading - outward * glm::dot(heading, outward), outward, along < 0.5 ? curl : -curl);
    heading = glm::normalize(heading);
  }
  lock.centre = (lock.points.front() + lock.points.back()) * 0.5;
  lock.reach = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    lock.reach = std::max(lock.reach, glm::distance(lock.centre, lock.points[i]) + lock.radii[i]);
  }
  return lock;
}

}  // namespace

std::vector<Lock> bust_locks() {
  constexpr int kDirections = 130;
  RandomNumbers random(5);
  std::vector<Lock> locks;
  for (int i = 0; i < kDirections; ++i) {
    // Evenly over the sphere, along a spiral of golden angles.
    const double height = 1.0 - 2.0 * (i + 0.5) / kDirections;
    const double angle = 2.0 * std::numbers::pi * i / std::numbers::phi;
    const double radius = std::sqrt(1.0 - height * height);
    const glm::dvec3 direction(radius * portable::cos(angle), height,
                               radius * portable::sin(angle));
    Lock lock = lock_at(direction, random);
    if (grows_hair(lock.points[0])) locks.push_back(std::move(lock));
  }
  return locks;
}

double bust_hair(const glm::dvec3& p, const std::vector<Lock>& locks) {
  constexpr double kGroove = 0.06;
  constexpr double kThickest = 0.3;  // beyond it no lock reaches
  const double scalp = Ellipsoid{kScalpCentre, kScalpRadii}(p);
  if (std::abs(scalp) > kThickest) return scalp;
  double hair = smooth_intersection(scalp - waves(p), hairline(p), 0.08);
  for (const Lock& lock : locks) {
    // Farther than this the blend below would leave the hair as it is.
    if (glm::distance(p, lock.centre) - lock.reach > hair + kGroove) continue;
    double distance = 1e9;
    for (std::size_t i = 0; i + 1 < lock.points.size(); ++i) {
      const Cone part{lock.points[i], lock.points[i + 1], lock.radii[i], lock.radii[i + 1]};
      distance = std::min(distance, part(p));
    }
    hair = smooth_union(hair, distance, kGroove);
  }
  return hair;
}

namespace {

double cravat(const glm::dvec3& p) {
  const auto band = [&](double height, double radius, double thickness) {
    const glm::dvec3 q = p - glm::dvec3(0.0, height, -0.08);
    return portable::hypot(portable::hypot(q.x, q.z) - radius, 0.8 * (q.y + 0.25 * q.z)) -
           thickness;
  };
  const double wrapped = smooth_union(band(-0.71, 0.265, 0.065), band(-0.84, 0.29, 0.075), 0.03);
  const double knot = Ellipsoid{{0.0, -0.93, 0.27}, {0.12, 0.09, 0.10}}(p);
  const double fall = Cone{{0.05, -1.02, 0.27}, {0.08, -1.32, 0.31}, 0.06, 0.09}(p);
  return smooth_union(smooth_union(wrapped, knot, 0.03), fall, 0.04);
}

double coat(const glm::dvec3& p) {
  double body = Ellipsoid{{0.0, -1.45, -0.10}, {0.70, 0.58, 0.40}}(p);
  body = smooth_union(body, Cone{{0.15, -1.02, -0.14}, {0.68, -1.28, -0.14}, 0.20, 0.25}(p), 0.2);
  const double shirt = Cone{{0.0, -0.95, 0.06}, {0.0, -1.50, 0.10}, 0.20, 0.25}(p);
  body = smooth_union(body, shirt, 0.10);
  const double lapel = Cone{{0.27, -0.86, 0.03}, {0.13, -1.55, 0.30}, 0.09, 0.13}(p);
  const double collar = Cone{{0.28, -0.84, 0.02}, {0.0, -0.80, -0.36}, 0.09, 0.10}(p);
  return smooth_union(body, smooth_union(lapel, collar, 0.08), 0.08);
}

double socle(const glm::dvec3& p) {
  const double distance = portable::hypot(p.x, p.z + 0.10);
  const double radius = 0.22 + 0.16 * smooth_step(-1.75, -2.1, p.y);
  const double stem = extruded(distance - radius, p.y + 1.85, 0.28, 0.03);
  const double plate = extruded(distance - 0.44, p.y + 2.10, 0.09, 0.06);
  return smooth_union(stem, plate, 0.08);
}

// The shoulders are turned a little against the head, which stays in line with the lattice: that
// keeps the quads of the face alike on both sides.
glm::dvec3 in_body(const glm::dvec3& p) {
  constexpr double kTurn = 0.22;
  const double cosine = portable::cos(kTurn);
  const double sine = portable::sin(kTurn);
  return {cosine * p.x - sine * (p.z + 0.1), p.y, cosine * (p.z + 0.1) + sine * p.x - 0.1};
}

// Cells grow with the distance from the face, where there is less to show.
glm::dvec3 finest_at_the_face(const glm::dvec3& p) {
  constexpr glm::dvec3 kFace(0.0, -0.08, 0.45);
  constexpr double kGrowth = 1.3;
  constexpr double kEvenWithin = 0.45;
  const double distance = glm::distance(p, kFace);
  const double beyond = std::max(distance - kEvenWithin, 0.0);
  const double stretch = 1.0 + 0.5 * kGrowth * beyond * beyond / std::max(distance, kEvenWithin);
  return kFace + (p - kFace) * stretch;
}

}  // namespace

double bust_body(const glm::dvec3& p) {
  const glm::dvec3 half(std::abs(p.x), p.y, p.z);  // both sides alike
  double body = smooth_union(coat(half), cravat(half), 0.055);
  // The cut of a bust: round below the arms.
  body = smooth_intersection(body, Ellipsoid{{0.0, -1.0, -0.12}, {0.85, 0.78, 0.62}}(p), 0.06);
  return smooth_union(body, socle(p), 0.06);
}

PolygonMesh bust() {
  constexpr double kHeadEnds = -0.85;
  constexpr double kBodyEnds = -0.40;
  const std::vector<Lock> locks = bust_locks();
  const auto field = [&](const glm::dvec3& p) {
    double bust = Cone{{0.0, -0.35, -0.12}, {0.0, -1.0, -0.12}, 0.25, 0.29}(p);  // neck
    // Parts too far off for their blends to matter are left out: they cost the most.
    if (p.y > kHeadEnds) {
      bust = smooth_union(smooth_union(bust_face(p), bust_hair(p, locks), 0.06), bust, 0.12);
    }
    return p.y < kBodyEnds ? smooth_union(bust, bust_body(in_body(p)), 0.06) : bust;
  };
  SurfaceNetsOptions options;
  options.cell = 0.0242;
  // The plane of symmetry runs through the middle of a layer of cells.
  options.low = {-32.5 * options.cell, -1.7013, -0.7617};
  options.high = {0.76, 0.87, 0.70};
  options.warp = finest_at_the_face;
  return surface_nets(field, options);
}

PolygonMesh scan(const PolygonMesh& shape, const Field& field, const Mesher& mesher,
                 const ScanOptions& options) {
  constexpr double kLongestStep = 0.01;  // facets lie that near to the surface they stand for
  PointCloud cloud;
  cloud.points = options.sampling == Sampling::Uniform
                     ? sample_uniform(shape, options.point_count, options.seed)
                     : sample_poisson_disk(shape, options.point_count, options.seed);
  for (glm::dvec3& p : cloud.points) {
    if (field) p = projected(field, p, kLongestStep);
    p = {rounded(p.x), rounded(p.y), rounded(p.z)};
  }
  ReconstructOptions reconstruction;
  reconstruction.tolerance = options.tolerance;
  reconstruction.least_angle = options.least_angle;
  reconstruction.pair_quads = options.pair_quads;
  reconstruction.clean.outliers = OutlierRule::Off;
  return reconstruct(cloud, mesher, reconstruction).mesh;
}

PolygonMesh scanned_rocker_arm(const Mesher& mesher) {
  ScanOptions options;
  options.point_count = 100'000;
  options.tolerance = 3e-4;
  options.least_angle = 3;  // a mesh that is hard to interpolate
  return scan(rocker_arm(), rocker_arm_field, mesher, options);
}

}  // namespace planish::shapes
