#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/fair/gpu_fair.h"

namespace planish::vulkan {

/// Collects passes with the buffers that their kernels bind.
struct GpuFair::Binder {
  const Context& context;
  shared::FairParameters common;
  std::vector<BoundKernel> bound{};

  Pass& add(Passes& passes, Kernel kernel, std::uint32_t count,
            std::initializer_list<const Buffer*> buffers) {
    BoundKernel& kernel_buffers = bound.emplace_back(BoundKernel{kernel, {}});
    for (const Buffer* buffer : buffers) kernel_buffers.buffers.push_back(whole(*buffer));
    Pass pass{context.pipelines().specialised(kernel, {}), bound.size() - 1, common,
              context.groups_of(count)};
    pass.parameters.count = count;
    return passes.emplace_back(pass);
  }

  // A kernel that writes a partial sum for each of its work groups, of which there is at least one.
  Pass& add_sum(Passes& passes, Kernel kernel, std::uint32_t count,
                std::initializer_list<const Buffer*> buffers) {
    Pass& pass = add(passes, kernel, count, buffers);
    pass.groups = std::clamp(pass.groups, 1u, shared::kMostSumGroups);
    return pass;
  }

  // The kernel of one work group that adds up what the last pass wrote.
  void add_total(Passes& passes, Kernel kernel, std::initializer_list<const Buffer*> buffers) {
    const std::uint32_t partial_count = passes.back().groups;
    add(passes, kernel, 1, buffers).parameters.partial_count = partial_count;
  }
};

}  // namespace planish::vulkan
