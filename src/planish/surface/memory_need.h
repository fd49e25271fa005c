#pragma once

#include <cstdint>

#include "planish/stencil/quad_split.h"

namespace planish {

/// Peak of host memory that tessellating down to `level` takes, in bytes: an upper estimate from
/// element counts.
[[nodiscard]] std::uint64_t tessellation_bytes(const QuadSplit& split, int level);

/// Memory that the machine can still give, in bytes: the least of what the kernel calls available
/// and what control groups leave; the largest value where neither can be read.
[[nodiscard]] std::uint64_t available_memory_bytes();

/// Throws Error{OutOfMemory} naming counts, need and limit when tessellating to `level` exceeds
/// `limit_bytes` (0: what is available) or 32-bit indices.
void require_memory(const QuadSplit& split, int level, std::uint64_t limit_bytes);

}  // namespace planish
