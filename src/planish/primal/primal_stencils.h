#pragma once

#include <cstdint>

#include "planish/core/range.h"
#include "planish/primal/primal_split.h"
#include "planish/stencil/sector_rows.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// From the vertices of M_level to those of M_(level + 1): one step of the scheme, rows of
/// M_(level + 1). Source: OpenSubdiv's masks.
[[nodiscard]] StencilTable primal_refinement_table(const PrimalSplit& split, int level,
                                                   RowRange rows);

/// The output vertices of M_level, level >= 1, of which the first `vertex_count` are wanted.
[[nodiscard]] SectorRows primal_sector_rows(const PrimalSplit& split, int level,
                                            std::int64_t vertex_count);

/// Limit points, with du and dv whose cross product is the outward normal's direction, of rows of
/// `sectors`, from the vertices of M_level, level >= 1. See StarLimits.
[[nodiscard]] StencilTable primal_limit_table(const PrimalSplit& split, int level,
                                              const SectorRows& sectors, RowRange rows);

/// The matrix B of the interpolation: row v gives the limit point of vertex v of the mesh from all
/// control points. The split must have a level 1. Rows sum to 1.
[[nodiscard]] StencilTable primal_limit_masks(const PrimalSplit& split);

}  // namespace planish
