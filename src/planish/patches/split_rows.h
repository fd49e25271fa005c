#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/surface_stencils.h"
#include "planish/patches/patch_numbering.h"
#include "planish/stencil/quad_split.h"

namespace planish {

/// The rows of the stencil tables, LimitRows of max(level, 1), in the numbering of patches without
/// hidden faces: entry i is row i's number in `limits`. The split must be refined to that level.
[[nodiscard]] std::vector<std::int32_t> limits_of_rows(const MeshTopology& topology,
                                                       const PatchNumbering& numbering,
                                                       const QuadSplit& split,
                                                       const LimitRows& limits);

}  // namespace planish
