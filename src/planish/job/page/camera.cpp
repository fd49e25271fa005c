#include "planish/job/page/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

namespace planish::render {
namespace {

constexpr float kFieldOfViewDegrees = 28;  // vertical; long enough to leave shapes undistorted

}  // namespace

glm::vec3 Camera::project(const glm::vec3& point) const {
  const glm::vec3 d = point - eye;
  const float inverse = 1.0f / glm::dot(d, forward);
  return {principal.x + focal * glm::dot(d, right) * inverse,
          principal.y - focal * glm::dot(d, up) * inverse, inverse};
}

glm::vec3 Camera::ray(const glm::vec2& image) const {
  const glm::vec2 d = (image - principal) / focal;
  return glm::normalize(forward + d.x * right - d.y * up);
}

Camera frame(std::span<const glm::vec3> points, int width, int height, const ViewOptions& options) {
  const float azimuth = glm::radians(options.azimuth_degrees);
  const float elevation = glm::radians(options.elevation_degrees);
  Camera camera;
  camera.forward = -glm::vec3(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                              std::cos(azimuth) * std::cos(elevation));
  camera.right = glm::vec3(std::cos(azimuth), 0, -std::sin(azimuth));
  camera.up = glm::cross(camera.right, camera.forward);
  camera.focal =
      0.5f * static_cast<float>(height) / std::tan(glm::radians(kFieldOfViewDegrees / 2));
  camera.principal = {0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height)};

  // The planes of the image's four sides pass through the eye: along each of their normals the
  // farthest point decides, and two opposite planes meet at the eye.
  const glm::vec2 half = (1 - 2 * options.margin) * camera.principal / camera.focal;
  constexpr float kLowest = std::numeric_limits<float>::lowest();
  glm::vec2 plus(kLowest), minus(kLowest);
  for (const glm::vec3& p : points) {
    const glm::vec2 across(glm::dot(p, camera.right), glm::dot(p, camera.up));
    const float along = glm::dot(p, camera.forward);
    plus = glm::max(plus, across - half * along);
    minus = glm::max(minus, -across - half * along);
  }
  const glm::vec2 centre = 0.5f * (plus - minus);
  const glm::vec2 along = -0.5f * (plus + minus) / half;
  camera.eye =
      centre.x * camera.right + centre.y * camera.up + std::min(along.x, along.y) * camera.forward;
  const glm::vec2 target = options.middle * 2.0f * camera.principal;
  camera.principal += options.zoom * (camera.principal - target);
  camera.focal *= options.zoom;
  return camera;
}

}  // namespace planish::render
