// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/triangles.h"

namespace planish::bench {

/// CGAL's advancing front surface reconstruction as its manual calls it, without anything of ours.
[[nodiscard]] std::vector<Triangle> mesh_by_cgal_alone(std::span<const glm::dvec3> points);

}  // namespace planish::bench
