#include "camera.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec4.hpp>

#include "planish/core/point_bounds.h"

namespace planish::viewer {
namespace {

constexpr float kFieldOfViewDegrees = 28;  // vertical; long enough to leave shapes undistorted
constexpr float kMargin = 1.02f;
constexpr float kLargestElevation = 89;  // above, "up" has no direction in the picture
constexpr float kDragDegrees = 220;      // for the picture's height
constexpr glm::vec3 kUp{0, 1, 0};

}  // namespace

glm::vec3 OrbitCamera::backward() const {
  const float azimuth = glm::radians(azimuth_degrees), elevation = glm::radians(elevation_degrees);
  return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
          std::cos(azimuth) * std::cos(elevation)};
}

float OrbitCamera::distance(float aspect) const {
  const float half_height = std::tan(glm::radians(kFieldOfViewDegrees / 2));
  const float half = std::atan(half_height * std::min(aspect, 1.0f));
  return kMargin * radius / std::sin(half) / zoom;
}

glm::vec3 OrbitCamera::eye(float aspect) const { return centre + distance(aspect) * backward(); }

glm::mat4 OrbitCamera::clip_from_world(float aspect) const {
  const float away = distance(aspect);
  const float near_plane = std::max(away - 1.5f * radius, 0.02f * away);
  glm::mat4 projection = glm::perspectiveRH_ZO(glm::radians(kFieldOfViewDegrees), aspect,
                                               near_plane, away + 1.5f * radius);
  projection[1][1] = -projection[1][1];
  return projection * glm::lookAtRH(eye(aspect), centre, kUp);
}

glm::vec3 OrbitCamera::key_light() const {
  const glm::vec3 right = glm::normalize(glm::cross(kUp, backward()));
  const glm::vec3 up = glm::cross(backward(), right);
  return glm::normalize(-0.55f * right + 0.65f * up + 0.65f * backward());
}

PictureRay OrbitCamera::ray_through(const glm::vec2& place, float aspect) const {
  const glm::dvec3 back(backward());
  const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(kUp), back));
  const glm::dvec3 up = glm::cross(back, right);
  const double half = std::tan(glm::radians(double{kFieldOfViewDegrees} / 2));
  const double x = (2.0 * place.x - 1) * half * aspect, y = (1 - 2.0 * place.y) * half;
  return {glm::dvec3(eye(aspect)), glm::normalize(x * right + y * up - back)};
}

std::optional<glm::vec2> OrbitCamera::place_of(const glm::dvec3& point, float aspect) const {
  const glm::vec4 clip = clip_from_world(aspect) * glm::vec4(glm::vec3(point), 1);
  if (!(clip.w > 0)) return std::nullopt;
  return 0.5f * (glm::vec2(clip) / clip.w + 1.0f);
}

glm::dvec3 OrbitCamera::moved_to(const glm::dvec3& point, const glm::vec2& place,
                                 float aspect) const {
  const PictureRay ray = ray_through(place, aspect);
  const glm::dvec3 back(backward());
  const double along = glm::dot(ray.direction, back);
  return ray.origin + ray.direction * (glm::dot(point - ray.origin, back) / along);
}

void OrbitCamera::orbit(float right, float down) {
  azimuth_degrees = std::remainder(azimuth_degrees - kDragDegrees * right, 360.0f);
  elevation_degrees =
      std::clamp(elevation_degrees + kDragDegrees * down, -kLargestElevation, kLargestElevation);
}

void OrbitCamera::zoom_by(float factor) {
  constexpr float kFarthest = 0.1f, kNearest = 20;
  zoom = std::clamp(zoom * factor, kFarthest, kNearest);
}

OrbitCamera camera_around(std::span<const glm::dvec3> points) {
  const auto [low, high] = point_bounds(points);
  OrbitCamera camera;
  camera.centre = 0.5 * (low + high);
  camera.radius = static_cast<float>(0.5 * glm::distance(low, high));
  return camera;
}

}  // namespace planish::viewer
