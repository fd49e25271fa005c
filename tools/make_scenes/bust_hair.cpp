#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "make_scenes/bust.h"
#include "make_scenes/implicit.h"
#include "make_scenes/random_numbers.h"

namespace planish::shapes {

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
  const double away = std::acos(std::clamp(glm::dot(direction, kPole), -1.0, 1.0));
  const double around = std::atan2(direction.x, glm::dot(direction, kUp));
  const double strand = kWaveCount * around + 1.6 * std::sin(4.5 * away + 2.0 * around) +
                        0.8 * std::sin(3.0 * around + 1.0);
  const double curl = 0.75 + 0.25 * std::sin(8.0 * away + 1.5 * std::sin(5.0 * around));
  const double fade = smooth_step(0.3, 0.9, away) * smooth_step(2.95, 2.25, away);
  return kHeight * fade * curl * (0.5 + 0.5 * std::cos(strand));
}

bool grows_hair(const glm::dvec3& p) {
  const bool is_by_the_ear = std::abs(p.x) > 0.3 && p.y < 0.10 && p.z > -0.14;
  return hairline(p) < 0.0 && hairline(p) > -0.20 && p.y > -0.42 && !is_by_the_ear;
}

glm::dvec3 turned(const glm::dvec3& v, const glm::dvec3& axis, double angle) {
  return v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) +
         axis * (glm::dot(axis, v) * (1.0 - std::cos(angle)));
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
    const glm::dvec3 direction(radius * std::cos(angle), height, radius * std::sin(angle));
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

}  // namespace planish::shapes
