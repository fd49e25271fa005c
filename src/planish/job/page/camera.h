#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>

namespace planish::render {

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

}  // namespace planish::render
