#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/context.h"

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

/// What has to come between a round of recorded work and the next. A round is what one recording
/// does between two of its barriers.
struct Wait {
  Scope from{}, to{};

  /// False where a recording has no such round any more.
  explicit operator bool() const noexcept { return from.stages != 0; }
  Wait& operator|=(const Wait& other) noexcept {
    from.stages |= other.from.stages, from.accesses |= other.from.accesses;
    to.stages |= other.to.stages, to.accesses |= other.to.accesses;
    return *this;
  }
};
inline constexpr Wait kKernelWait{kKernelScope, kKernelScope};

/// Recordings that do not depend on each other, in lock-step: round by round, each of `count`
/// records what it has of it by `record_round(i, round)`, which returns its Wait, and one barrier
/// stands for all. Rounds are counted from 0; a recording without a round has none after it.
template <class RecordRound>
void record_rounds(const Context& context, VkCommandBuffer commands, std::size_t count,
                   const RecordRound& record_round) noexcept {
  for (std::uint32_t round = 0;; ++round) {
    Wait wait;
    for (std::size_t i = 0; i < count; ++i) wait |= record_round(i, round);
    if (!wait) return;
    record_barrier(context, commands, wait.from, wait.to);
  }
}

/// A command buffer with a pool of its own and the fence of its submission. Externally
/// synchronised.
class FencedCommands {
 public:
  FencedCommands(Context& context, std::uint32_t queue_family);
  /// They must not be under way.
  ~FencedCommands();
  FencedCommands(const FencedCommands&) = delete;
  FencedCommands& operator=(const FencedCommands&) = delete;

  /// Records anew by `record`, makes what is written visible to the host, and submits. They must
  /// not be under way, and are not if this throws. Throws Error{DeviceLost}, Error{OutOfMemory}.
  void submit(VkQueue queue, const std::function<void(VkCommandBuffer)>& record);

  /// Waits up to `nanoseconds` for the last submission: VK_SUCCESS, VK_TIMEOUT or an error.
  [[nodiscard]] VkResult wait(std::uint64_t nanoseconds) const;

 private:
  Context& context_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

/// Submits to a queue and waits, on behalf of the command; an embedding host does this itself.
/// Externally synchronised.
class Submitter {
 public:
  Submitter(Context& context, VkQueue queue, std::uint32_t queue_family);
  ~Submitter();
  Submitter(const Submitter&) = delete;
  Submitter& operator=(const Submitter&) = delete;

  /// Records by `record`, submits and waits. What earlier submissions wrote is visible to it, and
  /// what it writes to mapped buffers is visible to the host after invalidate(). Throws
  /// Error{DeviceLost}.
  void run(const std::function<void(VkCommandBuffer)>& record);

  /// Fills `size` bytes of `target`, piece by piece: fill(offset, piece) writes the bytes that
  /// begin `offset` bytes into the range.
  void upload(const BufferRange& target,
              const std::function<void(std::uint64_t, std::span<std::byte>)>& fill);
  void upload(const BufferRange& target, std::span<const std::byte> bytes);

  /// Hands over the bytes of `source`, piece by piece.
  void download(const BufferRange& source,
                const std::function<void(std::uint64_t, std::span<const std::byte>)>& take);

 private:
  Context& context_;
  VkQueue queue_;
  FencedCommands commands_;
  Buffer upload_, download_;
};

}  // namespace planish::vulkan
