#include "animation.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace planish::viewer {
namespace {

constexpr double kPeriodSeconds = 7;
constexpr double kTwist = 0.7;    // radians between bottom and top
constexpr double kSway = 0.07;    // of the box's diagonal, at the top
constexpr double kBreath = 0.10;  // of the distance from the axis
constexpr double kWaves = 1.2;    // of breath along the height

}  // namespace

Animation::Animation(std::span<const glm::dvec3> rest)
    : rest_(rest.begin(), rest.end()), low_(std::numeric_limits<double>::max()), size_(0) {
  glm::dvec3 high(-low_);
  for (const glm::dvec3& p : rest_) {
    low_ = glm::min(low_, p);
    high = glm::max(high, p);
  }
  size_ = high - low_;
}

void Animation::pose(double seconds, std::span<glm::vec3> points) const {
  const double turn = 2 * std::numbers::pi, phase = turn * seconds / kPeriodSeconds;
  const glm::dvec3 middle = low_ + 0.5 * size_;
  const double diagonal = glm::length(size_);
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    // A flat shape lies at height 0 and only breathes.
    const double height = size_.y > 0 ? (rest_[i].y - low_.y) / size_.y : 0;
    const double angle = kTwist * height * std::sin(phase);
    const double scale = 1 + kBreath * std::sin(2 * phase) * std::cos(turn * kWaves * height);
    const glm::dvec3 arm = scale * (rest_[i] - middle);
    const double sway = kSway * diagonal * height * height * std::sin(phase);
    points[i] = {middle.x + std::cos(angle) * arm.x + std::sin(angle) * arm.z + sway, rest_[i].y,
                 middle.z - std::sin(angle) * arm.x + std::cos(angle) * arm.z};
  }
}

}  // namespace planish::viewer
