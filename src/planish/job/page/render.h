#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

#include "planish/core/portable_math.h"

namespace planish::render {

inline glm::vec3 raised(const glm::vec3& base, double exponent) {
  return {portable::pow(base.x, exponent), portable::pow(base.y, exponent),
          portable::pow(base.z, exponent)};
}

/// sRGB to linear light, by a power of 2.2.
inline glm::vec3 linear(const glm::vec3& srgb) { return raised(srgb, 2.2); }

/// Linear light, clamped, to sRGB.
inline glm::vec3 displayed(const glm::vec3& light) {
  return raised(glm::clamp(light, 0.0f, 1.0f), 1 / 2.2);
}

/// Leaves darks and mid tones alone and bends what is brighter towards 1.
inline glm::vec3 soft_shoulder(const glm::vec3& light) {
  constexpr double kStart = 0.6;
  const auto bend = [](double x) {
    return x < kStart ? x
                      : kStart + (1 - kStart) * (1 - portable::exp((kStart - x) / (1 - kStart)));
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
  constexpr double kOctaves = 6;
  const double octaves = portable::log2(std::max(curvature, 1.0f));
  const auto place =
      static_cast<float>(std::clamp(octaves / kOctaves, 0.0, 1.0) * (kStops.size() - 1));
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

/// A pinhole camera; image coordinates are in samples, x to the right, y down.
struct Camera {
  glm::vec3 eye, right, up, forward;
  float focal;          ///< samples at distance 1
  glm::vec2 principal;  ///< image point that `forward` meets

  /// x, y and 1 / depth, which is linear over a triangle's image.
  [[nodiscard]] glm::vec3 project(const glm::vec3& point) const;
  /// Unit direction from the eye through an image point.
  [[nodiscard]] glm::vec3 ray(const glm::vec2& image) const;
};

struct ViewOptions {
  float azimuth_degrees = 35, elevation_degrees = 20;  ///< of the eye; azimuth 0 looks along -z
  float margin = 0.08f;  ///< of the image's width and height, kept free all round
  /// What lies at `middle` (fractions of the image's width and height) moves to its middle and is
  /// enlarged by `zoom`.
  float zoom = 1;
  glm::vec2 middle{0.5f};
};

/// A camera of 28 degrees that frames all points in an image of `width` x `height` samples.
[[nodiscard]] Camera frame(std::span<const glm::vec3> points, int width, int height,
                           const ViewOptions& options);

/// The nearest thing at each sample: nearness (larger is nearer) and a number that says what.
struct VisibilityBuffer {
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();

  VisibilityBuffer(int w, int h)
      : width(w),
        height(h),
        nearness(static_cast<std::size_t>(w) * h, std::numeric_limits<float>::lowest()),
        what(static_cast<std::size_t>(w) * h, kNothing) {}

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * width + x;
  }

  int width, height;
  std::vector<float> nearness;
  std::vector<std::uint32_t> what;
};

/// Enters triangles, by their number, into rows [row_begin, row_end). Vertices are x, y in samples
/// and nearness; calls on rows that do not overlap may run at once.
void rasterise(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> indices,
               int row_begin, int row_end, VisibilityBuffer& buffer);

}  // namespace planish::render
