#pragma once

#include <opensubdiv/osd/bufferDescriptor.h>

#include <memory>
#include <vector>

#include "planish/osd/vk_device_context.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish::osd {

inline vulkan::FloatElements Elements(VkBuffer buffer,
                                      OpenSubdiv::Osd::BufferDescriptor const& desc) {
  return {buffer, static_cast<std::uint64_t>(desc.offset), static_cast<std::uint32_t>(desc.length),
          static_cast<std::uint32_t>(desc.stride)};
}

/// Records or submits one pass for each destination.
template <typename PASS>
void RunPasses(VkDeviceContext& deviceContext, std::shared_ptr<std::vector<PASS>> const& passes) {
  auto const record = [&](VkCommandBuffer commands) {
    for (PASS const& pass : *passes) {
      // Destinations may interleave in one buffer.
      if (&pass != passes->data())
        vulkan::record_barrier(deviceContext.GetContext(), commands, vulkan::kKernelScope,
                               vulkan::kKernelScope);
      pass.record(commands);
    }
  };
  deviceContext.Run(record, passes);
}

}  // namespace planish::osd
