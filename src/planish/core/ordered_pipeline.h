#pragma once

#include <cstddef>
#include <functional>
#include <span>

namespace planish {

/// One step of a pipeline with one of its pieces, which stands in one of the slots.
using PieceStep = std::function<void(std::size_t piece, std::size_t slot)>;

/// Calls make(piece, slot) for each piece in [0, count) on all threads, and then each of `takers`
/// in the pieces' order: one by one thread at a time, different ones side by side. At most `slots`
/// pieces exist at once, each in a slot of its own. Throws what the steps throw, and
/// Error{Cancelled} under a StopScope.
void ordered_pipeline(std::size_t count, std::size_t slots, const PieceStep& make,
                      std::span<const PieceStep> takers);

/// How many threads there are for it where this is called.
[[nodiscard]] std::size_t pipeline_threads();

}  // namespace planish
