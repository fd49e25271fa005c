#pragma once

#include <optional>
#include <vector>

#include "planish/vulkan/embed.h"
#include "planish/vulkan/fair/fair_tables.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

/// What a DeviceSystem holds, for the Solves made on it.
struct DeviceSystem::Parts {
  Parts(Context& context, const System& system, const DeviceSystemOptions& options);

  /// Bytes of the staging range that go to the start of a buffer.
  struct Copy {
    VkBuffer target;
    std::uint64_t bytes;
  };
  void plan_copies(const DeviceTable& table, bool has_derivatives);

  Context& context;
  std::uint32_t max_vertex_stride;
  std::int32_t given_count;
  std::uint32_t index_count;
  double spectral_bound;
  std::vector<std::int32_t> used_vertices;
  DeviceTable masks;
  std::vector<DeviceTable> refinement;
  DeviceTable limit;
  std::optional<FairTables> fair;  // where that is the method
  Buffer vertices;                 // used_vertices, on the device
  std::vector<Copy> copies;        // in the order of their bytes; indices come after them
  std::uint64_t device_bytes = 0;
};

}  // namespace planish::vulkan
