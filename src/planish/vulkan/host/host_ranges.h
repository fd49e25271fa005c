#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planish/vulkan/host/frame_slots.h"

namespace planish::vulkan {

/// Bytes of a host's buffer: of each instance `count` elements, each of which has `bytes` from
/// `offset` on.
struct HostRange {
  std::string what;  ///< as messages call it
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  std::uint64_t stride = 0, count = 0, bytes = 0;
  std::uint64_t instance_stride = 0, instances = 1;
};

/// Throws Error{InvalidArgument} where one that is read has a byte of one that is written.
void require_apart(std::span<const HostRange> read, std::span<const HostRange> written);
/// The same of every two of them, which are written together.
void require_apart(std::span<const HostRange> written);

/// What solves and edits read: points, and lists of what has moved.
[[nodiscard]] std::vector<HostRange> read_ranges(std::span<const FrameSlot> slots,
                                                 const InstanceSizes& sizes,
                                                 std::uint32_t instances);
/// What an evaluation writes of each vertex; `whose` says which vertices.
[[nodiscard]] std::vector<HostRange> vertex_ranges(const VertexLayout& layout,
                                                   const std::string& whose,
                                                   std::uint64_t vertex_count,
                                                   std::uint32_t instances);

}  // namespace planish::vulkan
