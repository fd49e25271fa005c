#include "planish/vulkan/device/commands.h"

#include <algorithm>
#include <cstring>

#include "planish/vulkan/device/driver.h"

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

FencedCommands::FencedCommands(Context& context, std::uint32_t queue_family) : context_(context) {
  const DeviceFunctions& vk = context.vk();
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = queue_family;
  check(vk.vkCreateCommandPool(context.device(), &pool, context.callbacks(), &pool_),
        "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkResult result = vk.vkAllocateCommandBuffers(context.device(), &allocate, &commands_);
  VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  if (result == VK_SUCCESS)
    result = vk.vkCreateFence(context.device(), &fence, context.callbacks(), &fence_);
  if (result != VK_SUCCESS) vk.vkDestroyCommandPool(context.device(), pool_, context.callbacks());
  check(result, "vkCreateFence");
}

FencedCommands::~FencedCommands() {
  const DeviceFunctions& vk = context_.vk();
  vk.vkDestroyFence(context_.device(), fence_, context_.callbacks());
  vk.vkDestroyCommandPool(context_.device(), pool_, context_.callbacks());
}

void FencedCommands::submit(VkQueue queue, const std::function<void(VkCommandBuffer)>& record) {
  const DeviceFunctions& vk = context_.vk();
  check(vk.vkResetCommandPool(context_.device(), pool_, 0), "vkResetCommandPool");
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vk.vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
  record(commands_);
  record_barrier(context_, commands_, kExitScope, kHostReadScope);
  check(vk.vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  check(vk.vkResetFences(context_.device(), 1, &fence_), "vkResetFences");
  check(vk.vkQueueSubmit(queue, 1, &submit, fence_), "vkQueueSubmit");
}

VkResult FencedCommands::wait(std::uint64_t nanoseconds) const {
  return context_.vk().vkWaitForFences(context_.device(), 1, &fence_, VK_TRUE, nanoseconds);
}

namespace {

// A multiple of 16 and 24, so that points are not torn between pieces.
constexpr std::uint64_t kPieceBytes = 12u << 20;

// A staging buffer that holds a piece of `size` bytes.
void make_room(Context& context, Buffer& staging, std::uint64_t size, MemoryUse use) {
  const std::uint64_t wanted = std::min(size, kPieceBytes);
  if (staging.size() >= wanted) return;
  staging = {};
  staging = Buffer(context, wanted, use);
}

}  // namespace

Submitter::Submitter(Context& context, VkQueue queue, std::uint32_t queue_family)
    : context_(context), queue_(queue), commands_(context, queue_family) {}

Submitter::~Submitter() { context_.vk().vkDeviceWaitIdle(context_.device()); }

void Submitter::run(const std::function<void(VkCommandBuffer)>& record) {
  commands_.submit(queue_, [&](VkCommandBuffer commands) {
    record_barrier(context_, commands, kExitScope, kEntryScope);
    record(commands);
  });
  const VkResult waited = commands_.wait(UINT64_MAX);
  // Whoever catches the error drops buffers that the work may still be using.
  if (waited != VK_SUCCESS) context_.vk().vkDeviceWaitIdle(context_.device());
  check(waited, "vkWaitForFences");
}

void Submitter::upload(const BufferRange& target,
                       const std::function<void(std::uint64_t, std::span<std::byte>)>& fill) {
  if (target.size == 0) return;
  make_room(context_, upload_, target.size, MemoryUse::Upload);
  for (std::uint64_t done = 0; done < target.size;) {
    const std::uint64_t piece = std::min(target.size - done, kPieceBytes);
    fill(done, upload_.mapped().first(piece));
    upload_.flush();
    run([&](VkCommandBuffer commands) {
      const VkBufferCopy copy{0, target.offset + done, piece};
      context_.vk().vkCmdCopyBuffer(commands, upload_.handle(), target.buffer, 1, &copy);
    });
    done += piece;
  }
}

void Submitter::upload(const BufferRange& target, std::span<const std::byte> bytes) {
  upload(target, [&](std::uint64_t offset, std::span<std::byte> piece) {
    std::memcpy(piece.data(), bytes.data() + offset, piece.size());
  });
}

void Submitter::download(
    const BufferRange& source,
    const std::function<void(std::uint64_t, std::span<const std::byte>)>& take) {
  if (source.size == 0) return;
  make_room(context_, download_, source.size, MemoryUse::Download);
  for (std::uint64_t done = 0; done < source.size;) {
    const std::uint64_t piece = std::min(source.size - done, kPieceBytes);
    run([&](VkCommandBuffer commands) {
      const VkBufferCopy copy{source.offset + done, 0, piece};
      context_.vk().vkCmdCopyBuffer(commands, source.buffer, download_.handle(), 1, &copy);
    });
    download_.invalidate();
    take(done, std::span<const std::byte>(download_.mapped()).first(piece));
    done += piece;
  }
}

}  // namespace planish::vulkan
