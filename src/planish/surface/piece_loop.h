#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/core/range.h"

namespace planish {

/// Calls body(piece) for all pieces on all threads; step "evaluate" goes from `from` to `to`.
template <class Body>
void for_pieces(std::span<const RowRange> pieces, const Callbacks& callbacks, double from,
                double to, const Body& body) {
  LoopProgress progress(callbacks, "evaluate", from, to, static_cast<std::int64_t>(pieces.size()));
  parallel_each(pieces.size(), 1, [&](std::size_t i) {
    body(pieces[i]);
    progress.add();
  });
}

}  // namespace planish
