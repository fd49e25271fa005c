#pragma once

#include <glm/vec3.hpp>

#include "planish/files/gltf/write_gltf.h"

namespace planish {

/// How the writer turns a position in model coordinates into the float32 numbers of the file, and
/// what position these numbers stand for. The one place where rounding happens.
class StoredPosition {
 public:
  explicit StoredPosition(const GltfOptions& options)
      : origin_(options.origin), z_up_(options.z_up) {}

  [[nodiscard]] glm::vec3 store(const glm::dvec3& model) const {
    return upright(glm::vec3(model - origin_));
  }
  /// Exact inverse of the turn, then the origin added in double.
  [[nodiscard]] glm::dvec3 load(const glm::vec3& stored) const {
    return origin_ + unturn(glm::dvec3(stored));
  }
  /// A position of the file's scene, with its node's translation, in model coordinates.
  [[nodiscard]] glm::dvec3 unturn(const glm::dvec3& world) const {
    return z_up_ ? glm::dvec3(world.x, -world.z, world.y) : world;
  }
  /// Of a normal.
  [[nodiscard]] glm::vec3 turn(const glm::vec3& normal) const { return upright(normal); }
  /// node.translation.
  [[nodiscard]] glm::dvec3 translation() const { return upright(origin_); }

 private:
  // Adding zero turns -0 into 0, so that the sign of nothing is not stored.
  template <class Vector>
  [[nodiscard]] Vector upright(const Vector& v) const {
    return (z_up_ ? Vector(v.x, v.z, -v.y) : v) + Vector(0);
  }

  glm::dvec3 origin_;
  bool z_up_;
};

}  // namespace planish
