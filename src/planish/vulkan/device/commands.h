#pragma once

#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/kernels.h"
#include "planish/vulkan/device/scope.h"

namespace planish::vulkan {

/// Labels what is recorded while it lives.
class LabelScope {
 public:
  LabelScope(const Context& context, VkCommandBuffer commands, const char* label) noexcept
      : labels_(context.labels()), commands_(commands) {
    labels_.begin(commands_, label);
  }
  ~LabelScope() { labels_.end(commands_); }
  LabelScope(const LabelScope&) = delete;
  LabelScope& operator=(const LabelScope&) = delete;

 private:
  const DebugLabels& labels_;
  VkCommandBuffer commands_;
};

void record_barrier(const Context& context, VkCommandBuffer commands, const Scope& from,
                    const Scope& to) noexcept;

/// `parameters` points to the kernel's own push constants; `groups` are work groups in x, and in z
/// where there may not be as many; `instances` are those in y.
void record_dispatch(const Context& context, VkCommandBuffer commands, const Pipeline& pipeline,
                     VkDescriptorSet set, const void* parameters, std::uint32_t groups,
                     std::uint32_t instances = 1) noexcept;
void record_dispatch(const Context& context, VkCommandBuffer commands, Kernel kernel,
                     VkDescriptorSet set, const void* parameters, std::uint32_t groups,
                     std::uint32_t instances = 1) noexcept;

/// A VkDispatchIndirectCommand in a buffer.
struct IndirectGroups {
  VkBuffer buffer;
  VkDeviceSize offset;
};

/// The same with work groups that the device reads; they were written within kIndirectScope.
void record_dispatch_indirect(const Context& context, VkCommandBuffer commands,
                              const Pipeline& pipeline, VkDescriptorSet set, const void* parameters,
                              const IndirectGroups& groups) noexcept;
void record_dispatch_indirect(const Context& context, VkCommandBuffer commands, Kernel kernel,
                              VkDescriptorSet set, const void* parameters,
                              const IndirectGroups& groups) noexcept;

}  // namespace planish::vulkan
