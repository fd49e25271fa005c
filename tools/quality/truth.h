#pragma once

#include <functional>
#include <glm/vec3.hpp>

#include "make_scenes/implicit.h"
#include "make_scenes/surface_nets.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// A point of the true shape, with its outward unit normal.
struct Foot {
  glm::dvec3 point, normal;
};

/// The shape that a mesh's vertices were taken from: the foot of a point near it. May be called
/// from several threads.
using Truth = std::function<Foot(const glm::dvec3&)>;

/// About the origin.
[[nodiscard]] Truth true_sphere(double radius);
/// Around the z axis.
[[nodiscard]] Truth true_torus(double radius, double tube_radius);
/// The zero set of a field; the foot along its gradient.
[[nodiscard]] Truth true_zero_set(shapes::Field field);
/// A dense mesh; between its vertices' normals, by angle, the others are interpolated.
[[nodiscard]] Truth true_mesh(const PolygonMesh& mesh);

}  // namespace planish::quality
