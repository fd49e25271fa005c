#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/raw_vector.h"
#include "planish/limit/cell_splitter.h"
#include "planish/limit/face_grid.h"
#include "planish/limit/limit_surface.h"

namespace planish {

/// The cells of all corners, and the grids of those faces that have one instead.
struct AdaptiveCells {
  std::vector<std::int64_t> first;  ///< corner_count + 1
  RawVector<AdaptiveCell> cells;
  std::vector<std::uint8_t> hidden;  ///< one a corner: of a hole, without cells
  std::vector<FaceGrid> grids;       ///< one a face

  [[nodiscard]] std::span<const AdaptiveCell> of(std::int32_t corner) const {
    const auto c = static_cast<std::size_t>(corner);
    return std::span(cells).subspan(static_cast<std::size_t>(first[c]),
                                    static_cast<std::size_t>(first[c + 1] - first[c]));
  }
};

/// On all threads, the same for every thread count. Throws as CellSplitter,
/// Error{OutOfMemory} before cells and what is made of them take more than `memory_limit_bytes`.
/// Callbacks: step "evaluate".
[[nodiscard]] AdaptiveCells make_cells(const LimitSurface& surface, const CellLimits& limits,
                                       std::uint64_t memory_limit_bytes,
                                       const Callbacks& callbacks = {});

}  // namespace planish
