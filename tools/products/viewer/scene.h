#pragma once

#include <vulkan/vulkan.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/fair/fair_net.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/settings.h"
#include "planish/vulkan/embed.h"

namespace planish::viewer {

inline constexpr int kMostIterations = 64;
inline constexpr int kMostLevel = 5;  // of the slider and --level

/// What flags set at first and a window's panel changes.
struct ViewSettings {
  int level = 2;
  int iterations = 6;  ///< of each frame
  bool warm_start = true;
  bool surface = true, cage = false, points = false, heat = false;
  bool texture = false;     ///< a board by texture coordinates, where the mesh has some
  bool tessellate = false;  ///< the surface as fine as it is seen, without errors and texture
  bool paused = false;

  [[nodiscard]] bool draws_squares() const { return texture && !heat; }
  [[nodiscard]] bool draws_patches() const { return tessellate && !heat && !texture; }
};

/// A shape that twists, sways and breathes about the upright axis through its middle. Smooth in
/// space and time; at rest at 0 seconds.
class Animation {
 public:
  explicit Animation(std::span<const glm::dvec3> rest);

  /// Writes the points at that time, one for each of the rest pose.
  void pose(double seconds, std::span<glm::vec3> points) const;

 private:
  std::vector<glm::dvec3> rest_;
  glm::dvec3 low_, size_;  // of the bounding box
};

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

// With prototypes, which planish's headers would leave out.

/// A mesh to animate and how planish shall interpolate it.
struct Scene {
  std::string name;
  PolygonMesh mesh;  ///< the rest pose; usable, y up
  vulkan::SystemOptions system;
  /// Of the fair method: what the rest pose's fit decided, which `system` names.
  std::shared_ptr<const FairDecisions> decisions;
  FitSettings settings;  ///< of the job; what files of it say
  std::string source;    ///< the input's path
};

/// The job of that name of a scene file of the command (*.json; no name: its first), or a mesh in
/// any format that the command reads. It is fitted as the command does: repairs, creases, weights,
/// tolerance, the first level and the method are the job's, or those that measurement takes;
/// `method`: no other than this. Throws Error{InvalidArgument}, Error{UnreadableInput},
/// Error{UnusableMesh}.
[[nodiscard]] Scene load_scene(const std::string& path, const std::string& job,
                               std::optional<InterpolationMethod> method = {});

}  // namespace planish::viewer
