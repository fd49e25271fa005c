#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// Bust of a composer, y up, looking along +z: face, wild hair, cravat, coat and socle. Quads only,
/// genus 0, about 16,400 vertices.
[[nodiscard]] PolygonMesh bust();

/// Its parts as distance functions; see implicit.h.
[[nodiscard]] double bust_face(const glm::dvec3& p);
[[nodiscard]] double bust_body(const glm::dvec3& p);

/// A lock of hair: a chain of balls swept into each other.
struct Lock {
  std::vector<glm::dvec3> points;
  std::vector<double> radii;
  glm::dvec3 centre;  ///< of a ball that holds it
  double reach;       ///< that ball's radius
};

/// The locks of the head, always the same.
[[nodiscard]] std::vector<Lock> bust_locks();
[[nodiscard]] double bust_hair(const glm::dvec3& p, const std::vector<Lock>& locks);

}  // namespace planish::shapes
