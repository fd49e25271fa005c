#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "planish/vulkan/device/buffer.h"
#include "planish/vulkan/device/fenced_commands.h"

namespace planish::vulkan {

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
