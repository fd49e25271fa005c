#pragma once

#include <cstdint>
#include <vector>

#include "planish/patches/patch_mesh.h"

namespace planish::vulkan {

/// Where the points of the state of level 1 are seen from: the vertex of a corner; of a curve point
/// the end of its edge that it lies next to; a corner vertex itself.
[[nodiscard]] std::vector<std::int32_t> state_owners(const PatchMesh& mesh);

}  // namespace planish::vulkan
