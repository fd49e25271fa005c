#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "planish/job/page/camera.h"
#include "render_mesh.h"

namespace planish::render {

/// A point that is lit: its light counts from the side that `normal` points to.
struct LitPoint {
  glm::vec3 position, normal;
};

/// A studio: a broad soft light above the camera's left, a weaker one on its right, an even room
/// and a bright floor. The mesh casts soft shadows; light that it throws back is left out.
class DomeLight {
 public:
  DomeLight(const RenderMesh& mesh, const Camera& camera);

  /// Irradiance at each point, 1 being that of a free point which faces the main light.
  [[nodiscard]] std::vector<float> irradiance(const std::vector<LitPoint>& points) const;
  /// The same without the mesh in the way.
  [[nodiscard]] float free_irradiance(const glm::vec3& normal) const;

  /// Direction to the middle of the main light.
  [[nodiscard]] const glm::vec3& key() const { return key_; }

 private:
  struct Lamp {
    glm::vec3 direction;
    float power;
  };
  void add_cone(const glm::vec3& axis, float half_angle_degrees, int count, float power);

  const RenderMesh& mesh_;
  std::vector<Lamp> lamps_;
  glm::vec3 key_;
  glm::vec3 centre_;
  float radius_;
  float unit_ = 1;
};

}  // namespace planish::render
