#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The area_vector() of every face, on all threads.
[[nodiscard]] std::vector<glm::dvec3> face_areas(const PolygonMesh& mesh);

}  // namespace planish
