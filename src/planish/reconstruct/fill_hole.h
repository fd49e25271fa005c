#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/triangles.h"

namespace planish {

/// A hole to be closed.
struct Hole {
  std::vector<std::int32_t> loop;   ///< vertices so that a patch runs from each to the next
  std::vector<glm::dvec3> normals;  ///< unit normal of the triangle beyond edge i to i + 1
};

/// The triangulation of the loop whose largest dihedral angle, patch and rim taken together, is
/// least, and among these the one of least area. `is_edge(a, b)` tells edges that the mesh has
/// already, which the patch must not use inside. Empty if there is none.
/// Source: P. Liepa, "Filling Holes in Meshes", 2003, section 3. Time grows as the cube of the
/// loop's length.
[[nodiscard]] std::vector<Triangle> fill_hole(
    std::span<const glm::dvec3> positions, const Hole& hole,
    const std::function<bool(std::int32_t, std::int32_t)>& is_edge);

}  // namespace planish
