#include "make_scenes/bust.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "make_scenes/implicit.h"
#include "make_scenes/surface_nets.h"

namespace planish::shapes {

namespace {

double cravat(const glm::dvec3& p) {
  const auto band = [&](double height, double radius, double thickness) {
    const glm::dvec3 q = p - glm::dvec3(0.0, height, -0.08);
    return std::hypot(std::hypot(q.x, q.z) - radius, 0.8 * (q.y + 0.25 * q.z)) - thickness;
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
  const double distance = std::hypot(p.x, p.z + 0.10);
  const double radius = 0.22 + 0.16 * smooth_step(-1.75, -2.1, p.y);
  const double stem = extruded(distance - radius, p.y + 1.85, 0.28, 0.03);
  const double plate = extruded(distance - 0.44, p.y + 2.10, 0.09, 0.06);
  return smooth_union(stem, plate, 0.08);
}

// The shoulders are turned a little against the head, which stays in line with the lattice: that
// keeps the quads of the face alike on both sides.
glm::dvec3 in_body(const glm::dvec3& p) {
  constexpr double kTurn = 0.22;
  const double cosine = std::cos(kTurn);
  const double sine = std::sin(kTurn);
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

}  // namespace planish::shapes
