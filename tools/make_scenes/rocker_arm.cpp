#include "make_scenes/rocker_arm.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "make_scenes/implicit.h"
#include "make_scenes/surface_nets.h"

namespace planish::shapes {

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

}  // namespace planish::shapes
