#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/vec3.hpp>

namespace planish::render {

/// sRGB to linear light, by a power of 2.2.
inline glm::vec3 linear(const glm::vec3& srgb) { return glm::pow(srgb, glm::vec3(2.2f)); }

/// Linear light, clamped, to sRGB.
inline glm::vec3 displayed(const glm::vec3& light) {
  return glm::pow(glm::clamp(light, 0.0f, 1.0f), glm::vec3(1 / 2.2f));
}

/// Leaves darks and mid tones alone and bends what is brighter towards 1.
inline glm::vec3 soft_shoulder(const glm::vec3& light) {
  constexpr float kStart = 0.6f;
  const auto bend = [](float x) {
    return x < kStart ? x : kStart + (1 - kStart) * (1 - std::exp((kStart - x) / (1 - kStart)));
  };
  return {bend(light.x), bend(light.y), bend(light.z)};
}

/// Linear colour of a curvature in radians over the bounding-box diagonal, logarithmic from 1 to
/// 64: from blue over green to yellow, readable in grey too.
inline glm::vec3 heat_colour(float curvature) {
  constexpr std::array<glm::vec3, 5> kStops{
      glm::vec3(0.27f, 0.23f, 0.52f), glm::vec3(0.20f, 0.45f, 0.56f),
      glm::vec3(0.16f, 0.64f, 0.52f), glm::vec3(0.55f, 0.80f, 0.32f),
      glm::vec3(0.99f, 0.90f, 0.25f)};
  constexpr float kOctaves = 6;
  const float place =
      std::clamp(std::log2(std::max(curvature, 1.0f)) / kOctaves, 0.0f, 1.0f) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  return linear(glm::mix(kStops[below], kStops[below + 1], place - static_cast<float>(below)));
}

/// Linear colour of a number from -1 to 1: blue below, red above, pale at 0; by vik of F. Crameri.
/// Grey where there is no number.
inline glm::vec3 signed_colour(float place) {
  constexpr std::array<glm::vec3, 5> kStops{
      glm::vec3(0.01f, 0.24f, 0.49f), glm::vec3(0.44f, 0.65f, 0.77f),
      glm::vec3(0.93f, 0.90f, 0.88f), glm::vec3(0.83f, 0.59f, 0.45f),
      glm::vec3(0.55f, 0.15f, 0.02f)};
  if (!std::isfinite(place)) return linear(glm::vec3(0.5f));
  const float along = 0.5f * (std::clamp(place, -1.0f, 1.0f) + 1) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(along), kStops.size() - 2);
  return linear(glm::mix(kStops[below], kStops[below + 1], along - static_cast<float>(below)));
}

}  // namespace planish::render
