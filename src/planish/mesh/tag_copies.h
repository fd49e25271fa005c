#pragma once

#include <cstdint>
#include <span>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Creases and corners hold on every copy of their edge or vertex: makes tags of the copies from
/// those of the originals. Vertices from `original_count` on are copies, `sources` has the original
/// of every vertex. Creases that name no edge stay. Time and result are linear in vertices, edges
/// and tags, but for a logarithm.
void copy_tags(PolygonMesh& mesh, std::span<const std::int32_t> sources,
               std::int32_t original_count);

/// Removes the tags that name no edge or used vertex, or whose sharpness is NaN; returns their
/// number. Faces must have at least two corners and indices in range.
std::int64_t drop_unknown_tags(PolygonMesh& mesh);

}  // namespace planish
