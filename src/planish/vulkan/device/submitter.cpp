#include "planish/vulkan/device/submitter.h"

#include <algorithm>
#include <cstring>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

namespace {

// A multiple of 16 and 24, so that points are not torn between pieces.
constexpr std::uint64_t kPieceBytes = 12u << 20;

/// A staging buffer that holds a piece of `size` bytes.
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
