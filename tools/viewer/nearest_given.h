#pragma once

// With prototypes, which planish's headers would leave out.
#include <vulkan/vulkan.h>

#include <cstdint>
#include <vector>

#include "planish/vulkan/embed.h"

namespace planish::viewer {

/// For each vertex of a System's surface the given points that fewest edges of the surface lead
/// to, as rows of System::used_vertices(): a given point's own limit point has that point alone,
/// the middle of a face all of its corners. Those of vertex i are rows[offsets[i]] to
/// rows[offsets[i + 1]].
struct NearestGiven {
  std::vector<std::uint32_t> offsets, rows;
};

[[nodiscard]] NearestGiven nearest_given(const vulkan::System& system);

}  // namespace planish::viewer
