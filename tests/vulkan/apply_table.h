#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/solve/stencil_table.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::testing {

/// `target` once the device has written the rows of `table`, applied to `source`, from place
/// `first` of it on.
[[nodiscard]] inline std::vector<glm::dvec3> applied(vulkan::VulkanMachine& machine,
                                                     const StencilTable& table,
                                                     std::span<const glm::dvec3> source,
                                                     const std::vector<glm::dvec3>& target,
                                                     std::uint64_t first = 0) {
  using namespace vulkan;
  constexpr std::uint32_t kFloats = shared::kPointFloats;
  DeviceTable rows(machine.context, table.view(), {});
  machine.upload_table(rows, table.view());
  const Buffer from(machine.context, source.size() * kPointBytes, MemoryUse::Device);
  const Buffer to(machine.context, target.size() * kPointBytes, MemoryUse::Device);
  machine.upload_points(from, source);
  machine.upload_points(to, target);
  const StencilPass pass(machine.context, rows, {from.handle(), 0, 3, kFloats},
                         {to.handle(), first * kFloats, 3, kFloats}, {0, rows.row_count()});
  machine.submitter.run([&](VkCommandBuffer commands) { pass.record(commands); });
  return machine.download_points(to, target.size());
}

}  // namespace planish::testing
