#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

namespace planish::viewer {

/// From the eye through a place of the picture.
struct PictureRay {
  glm::dvec3 origin{}, direction{};
};

/// A camera of 28 degrees that orbits a sphere; y is up.
struct OrbitCamera {
  glm::vec3 centre{0};
  float radius = 1;                                    ///< of the sphere that it keeps in view
  float azimuth_degrees = 35, elevation_degrees = 20;  ///< of the eye; azimuth 0 looks along -z
  float zoom = 1;                                      ///< above 1: nearer

  /// `aspect` is the picture's width over its height.
  [[nodiscard]] glm::vec3 eye(float aspect) const;
  /// To Vulkan's clip space: y down, depth 0 to 1.
  [[nodiscard]] glm::mat4 clip_from_world(float aspect) const;
  /// Unit direction to the main light, which moves with the eye: from its upper left.
  [[nodiscard]] glm::vec3 key_light() const;

  /// Places are in parts of the picture, (0, 0) its upper left, (1, 1) its lower right.
  [[nodiscard]] PictureRay ray_through(const glm::vec2& place, float aspect) const;
  /// Empty where the point is not before the eye.
  [[nodiscard]] std::optional<glm::vec2> place_of(const glm::dvec3& point, float aspect) const;
  /// The point at a place of the picture that is as far along the view as `point`.
  [[nodiscard]] glm::dvec3 moved_to(const glm::dvec3& point, const glm::vec2& place,
                                    float aspect) const;

  /// Drags the sphere's front by a fraction of the picture's height; never over a pole.
  void orbit(float right, float down);
  void zoom_by(float factor);

 private:
  [[nodiscard]] glm::vec3 backward() const;  // unit, from the centre to the eye
  [[nodiscard]] float distance(float aspect) const;
};

/// A camera whose sphere holds the points' bounding box.
[[nodiscard]] OrbitCamera camera_around(std::span<const glm::dvec3> points);

}  // namespace planish::viewer
