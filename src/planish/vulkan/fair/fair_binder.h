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

  /// Of `count` elements `large_count` are done by a work group each, where the kernel walks around
  /// them.
  Pass& add(Passes& passes, Kernel kernel, std::uint32_t count,
            std::initializer_list<const Buffer*> buffers, std::uint32_t large_count = 0) {
    BoundKernel& kernel_buffers = bound.emplace_back(BoundKernel{kernel, {}});
    for (const Buffer* buffer : buffers) kernel_buffers.buffers.push_back(whole(*buffer));
    Pass pass{context.pipelines().specialised(kernel, {}), bound.size() - 1, common,
              context.groups_of(count)};
    pass.parameters.count = count;
    if (large_count > 0) {
      const std::uint32_t by_groups[] = {1};
      pass.large = context.pipelines().specialised(kernel, by_groups);
      pass.large_count = large_count;
      pass.large_groups = std::min(large_count, context.max_group_count());
    }
    return passes.emplace_back(pass);
  }

  // A kernel that adds up over its work groups, of which there is at least one.
  Pass& add_sum(Passes& passes, Kernel kernel, std::uint32_t count,
                std::initializer_list<const Buffer*> buffers, std::uint32_t large_count = 0) {
    Pass& pass = add(passes, kernel, count, buffers, large_count);
    pass.groups = std::clamp(pass.groups, 1u, shared::kMostSumGroups);
    pass.large_groups = std::min(pass.large_groups, shared::kMostSumGroups);
    pass.parameters.partial_count = pass.groups + pass.large_groups;
    return pass;
  }
};

}  // namespace planish::vulkan
