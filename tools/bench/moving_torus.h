#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// torus_grid of about `point_count` points, each moved by up to a tenth of an edge in every
/// direction, as scanned points lie. The same bits on every call.
[[nodiscard]] PolygonMesh rough_torus(std::int32_t point_count);

/// The points as they are `frame` sixtieths of a second into a motion: twisted about the x axis, to
/// and fro once a second, by up to half a radian a unit of length.
[[nodiscard]] std::vector<glm::vec3> twisted(const PolygonMesh& rest, int frame);

}  // namespace planish::bench
