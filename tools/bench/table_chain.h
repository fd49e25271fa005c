#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// Rows of a level of the mesh's Doo-Sabin surface by what stood in place of patches: a chain of
/// stencil tables, made and applied in slices. Both as long as limit points of the level.
void apply_table_chain(const PolygonMesh& mesh, int level, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals);

}  // namespace planish::bench
