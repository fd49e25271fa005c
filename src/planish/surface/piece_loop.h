#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "planish/core/callbacks.h"
#include "planish/core/parallel.h"
#include "planish/stencil/stencil_builder.h"

namespace planish {

/// Calls body(piece) for all pieces on all threads, and between some of them the callbacks, on the
/// calling thread: step "evaluate" goes from `from` to `from + share`.
template <class Body>
void for_pieces(std::span<const RowRange> pieces, const Callbacks& callbacks, double from,
                double share, const Body& body) {
  constexpr std::size_t kPiecesAtOnce = 256;
  for (std::size_t first = 0; first < pieces.size(); first += kPiecesAtOnce) {
    callbacks.check_cancelled();
    const auto some = pieces.subspan(first, std::min(kPiecesAtOnce, pieces.size() - first));
    parallel_for(some.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(some[i]);
    });
    callbacks.report("evaluate", from + share * static_cast<double>(first + some.size()) /
                                            static_cast<double>(pieces.size()));
  }
}

}  // namespace planish
