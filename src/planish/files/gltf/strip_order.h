#pragma once

#include <cstdint>
#include <span>

#include "planish/core/raw_vector.h"

namespace planish {

/// Triangles and vertices in an order in which neighbours follow each other.
struct StripOrder {
  RawVector<std::uint32_t> indices;       ///< of the triangles, naming vertices in the new order
  RawVector<std::uint32_t> new_vertices;  ///< by old vertex; every vertex has one
};

/// Triangles in strips, blocks of them on all threads, then vertices as triangles first use them;
/// those that none uses come last. The result does not depend on the threads.
/// Source: meshoptimizer's vertex cache optimiser for strips.
[[nodiscard]] StripOrder strip_order(std::span<const std::uint32_t> indices,
                                     std::size_t vertex_count);

}  // namespace planish
