#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

void record_barrier(const Context& context, VkCommandBuffer commands, const Scope& from,
                    const Scope& to) noexcept {
  VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = from.accesses;
  barrier.dstAccessMask = to.accesses;
  context.vk().vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &barrier, 0, nullptr, 0,
                                    nullptr);
}

namespace {

void bind(const Context& context, VkCommandBuffer commands, const Pipeline& pipeline,
          VkDescriptorSet set, const void* parameters) noexcept {
  const DeviceFunctions& vk = context.vk();
  vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.pipeline);
  vk.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout, 0, 1, &set,
                             0, nullptr);
  vk.vkCmdPushConstants(commands, pipeline.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                        pipeline.parameter_bytes, parameters);
}

}  // namespace

void record_dispatch(const Context& context, VkCommandBuffer commands, Kernel kernel,
                     VkDescriptorSet set, const void* parameters, std::uint32_t groups,
                     std::uint32_t instances) noexcept {
  record_dispatch(context, commands, context.pipelines()[kernel], set, parameters, groups,
                  instances);
}

void record_dispatch(const Context& context, VkCommandBuffer commands, const Pipeline& pipeline,
                     VkDescriptorSet set, const void* parameters, std::uint32_t groups,
                     std::uint32_t instances) noexcept {
  bind(context, commands, pipeline, set, parameters);
  const auto [x, z] = context.groups_in_layers(groups);
  context.vk().vkCmdDispatch(commands, x, instances, z);
}

void record_dispatch_indirect(const Context& context, VkCommandBuffer commands, Kernel kernel,
                              VkDescriptorSet set, const void* parameters,
                              const IndirectGroups& groups) noexcept {
  record_dispatch_indirect(context, commands, context.pipelines()[kernel], set, parameters, groups);
}

void record_dispatch_indirect(const Context& context, VkCommandBuffer commands,
                              const Pipeline& pipeline, VkDescriptorSet set, const void* parameters,
                              const IndirectGroups& groups) noexcept {
  bind(context, commands, pipeline, set, parameters);
  context.vk().vkCmdDispatchIndirect(commands, groups.buffer, groups.offset);
}

}  // namespace planish::vulkan
