#include "planish/osd/patch_pass.h"

#include <algorithm>

#include "planish/vulkan/device/commands.h"

namespace planish::osd {

namespace {

namespace shared = vulkan::shared;

constexpr std::uint32_t kGroupSize = 64;
constexpr std::uint64_t kCoordBytes = shared::kPatchCoordWords * sizeof(float);
static_assert(kGroupSize * kCoordBytes % vulkan::kBindingAlignment == 0);

}  // namespace

PatchPass::PatchPass(vulkan::Context& context, PatchBuffers const& patches,
                     PatchCoords const& coords, vulkan::FloatElements const& source,
                     vulkan::FloatElements const& target, int derivative)
    : _context(context) {
  std::uint32_t const constants[] = {source.length, source.stride, target.stride,
                                     static_cast<std::uint32_t>(derivative)};
  _pipeline = context.pipelines().specialised(vulkan::Kernel::EvalPatches, constants);
  vulkan::ElementWindow const from = vulkan::element_window(source, 0, patches.numPoints);
  require_window(context, from, "control points of patches");
  std::uint64_t const step = vulkan::elements_at_once(
      context, std::max(shared::kPatchCoordWords, target.stride), kGroupSize);
  std::vector<vulkan::BoundKernel> bound;
  for (std::uint64_t first = 0; first < std::uint64_t(coords.count); first += step) {
    std::uint64_t const count = std::min(step, coords.count - first);
    vulkan::ElementWindow const to = vulkan::element_window(target, first, count);
    require_window(context, to, "results of patches");
    Dispatch& dispatch = _dispatches.emplace_back();
    dispatch.parameters.coord_count = static_cast<std::uint32_t>(count);
    dispatch.parameters.array_count = static_cast<std::uint32_t>(patches.patchArrays.size());
    dispatch.parameters.first_source = from.shift;
    dispatch.parameters.first_target = to.shift;
    dispatch.groups = static_cast<std::uint32_t>((count + kGroupSize - 1) / kGroupSize);
    bound.push_back({vulkan::Kernel::EvalPatches,
                     {{coords.buffer, first * kCoordBytes, count * kCoordBytes},
                      whole(patches.arrays),
                      whole(patches.indices),
                      whole(*patches.params),
                      from.range,
                      to.range}});
  }
  _sets = vulkan::DescriptorSets(context, bound);
}

void PatchPass::record(VkCommandBuffer commands) const noexcept {
  for (std::size_t i = 0; i < _dispatches.size(); ++i) {
    // Windows of neighbouring dispatches may share their edge.
    if (i > 0)
      vulkan::record_barrier(_context, commands, vulkan::kKernelScope, vulkan::kKernelScope);
    vulkan::record_dispatch(_context, commands, _pipeline, _sets[i], &_dispatches[i].parameters,
                            _dispatches[i].groups);
  }
}

}  // namespace planish::osd
