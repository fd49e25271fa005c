#pragma once

#include <glm/vec3.hpp>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// Rocker arm of an engine, y up: a bored hub along z, a ribbed arm to a boss with a blind socket
/// for the push rod, another down to the valve pad. Quads only, genus 1, about 14,000 vertices.
[[nodiscard]] PolygonMesh rocker_arm();

/// The shape that it stands for: negative inside, zero on the surface.
[[nodiscard]] double rocker_arm_field(const glm::dvec3& p);

}  // namespace planish::shapes
