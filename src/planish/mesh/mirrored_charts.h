#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Cuts indices of texture coordinates in two that belong to faces which lie either way round in
/// the texture: along the middle of charts that are mirrored in place, where the map turns back and
/// tangents jump. Once for each set of coordinates: `uvs`, as many as PolygonMesh::uvs, which get
/// the new ones' copies. Returns which index each new one copies, for the other sets.
std::vector<std::int32_t> cut_mirrored_charts(PolygonMesh& mesh, std::span<const glm::dvec2> uvs);

}  // namespace planish
