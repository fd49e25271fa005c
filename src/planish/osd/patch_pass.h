#pragma once

#include <cstdint>
#include <vector>

#include "planish/osd/patch_buffers.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish::osd {

/// Where patches are evaluated: Osd::PatchCoord, `count` of them from the buffer's start on.
struct PatchCoords {
  VkBuffer buffer = VK_NULL_HANDLE;
  int count = 0;
};

/// Element i of the target = the patch at coordinate i, or a derivative of it: 0 value, 1 du, 2 dv,
/// 3 duu, 4 duv, 5 dvv. Zero where the coordinate names no patch of a type that
/// Osd::CpuEvaluator evaluates. Patches and buffers outlive it.
class PatchPass {
 public:
  /// Both sides have the same length. Throws planish::Error{OutOfMemory} naming the limit that the
  /// patches' points exceed.
  PatchPass(vulkan::Context& context, PatchBuffers const& patches, PatchCoords const& coords,
            vulkan::FloatElements const& source, vulkan::FloatElements const& target,
            int derivative);

  /// Only records, within vulkan::kEntryScope and kExitScope.
  void record(VkCommandBuffer commands) const noexcept;

 private:
  struct Dispatch {
    vulkan::shared::PatchParameters parameters;
    std::uint32_t groups;
  };

  vulkan::Context& _context;
  vulkan::Pipeline _pipeline;
  std::vector<Dispatch> _dispatches;
  vulkan::DescriptorSets _sets;
};

}  // namespace planish::osd
