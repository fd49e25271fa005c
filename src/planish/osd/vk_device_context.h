#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "planish/vulkan/device/context.h"

namespace planish::vulkan {
class Buffer;
}

namespace planish::osd {

/// The DEVICE_CONTEXT of this module's classes: where their commands go. While a command buffer of
/// the host is set, calls record into it and return. Otherwise they submit to the queue and return,
/// and Synchronize() waits.
///
/// Every call begins with a barrier that orders it after all compute and transfer commands before
/// it (vulkan::kExitScope to vulkan::kEntryScope of context.h); what follows the last call is the
/// host's to order. Externally synchronised: one for each thread; any number may share a
/// vulkan::Context, which outlives them.
class VkDeviceContext {
 public:
  /// Only records; calls need a command buffer.
  explicit VkDeviceContext(vulkan::Context& context);
  /// The queue is externally synchronised, and of a family with compute.
  VkDeviceContext(vulkan::Context& context, VkQueue queue, std::uint32_t queueFamily);
  /// Waits for what was submitted. Recorded commands must have completed.
  ~VkDeviceContext();
  VkDeviceContext(VkDeviceContext const&) = delete;
  VkDeviceContext& operator=(VkDeviceContext const&) = delete;

  /// Calls from now on are recorded into `commands`: recording, outside a render pass, of a family
  /// with compute. VK_NULL_HANDLE: they are submitted.
  void SetCommandBuffer(VkCommandBuffer commands);
  VkCommandBuffer GetCommandBuffer() const;

  /// Frees what the calls recorded into `commands` need: descriptor sets and staging. To be called
  /// once it has completed and is not submitted again.
  void Release(VkCommandBuffer commands);

  /// Waits for all that was submitted. Recorded commands are the host's to wait for. Throws
  /// planish::Error{DeviceLost}.
  void Synchronize();

  vulkan::Context& GetContext() const;

  /// Usage flags that a buffer of the host's own needs where an evaluator reads or writes it.
  VkBufferUsageFlags GetBufferUsage() const;

  /// Records or submits `record`; `resources` live until it is done. Throws planish::Error, also
  /// where there is neither a command buffer nor a queue.
  void Run(std::function<void(VkCommandBuffer)> const& record, std::shared_ptr<void> resources);

  /// Lets go of a resource once no command given so far can use it.
  void Retire(std::shared_ptr<void> const& resource);

  /// Copies `bytes` into a buffer, `offset` bytes in; they are free at once. Throws planish::Error.
  void Upload(VkBuffer target, std::uint64_t offset, std::span<std::byte const> bytes);
  /// Waits. Throws planish::Error, also while a command buffer is set.
  std::vector<std::byte> Download(VkBuffer source, std::uint64_t offset, std::uint64_t size);

 private:
  /// A mapped buffer of at least `size` bytes to copy from, used again once nobody holds it.
  std::shared_ptr<vulkan::Buffer> GetStaging(std::uint64_t size);

  struct State;
  std::unique_ptr<State> _state;
};

}  // namespace planish::osd
