#include "planish/vulkan/host/host_ranges.h"

#include <algorithm>

namespace planish::vulkan {

namespace {

std::uint64_t block_bytes(const HostRange& range) {
  return (range.count - 1) * range.stride + range.bytes;
}
std::uint64_t end_of(const HostRange& range) {
  return range.offset + (range.instances - 1) * range.instance_stride + block_bytes(range);
}
bool is_empty(const HostRange& range) {
  return !range.buffer || range.count == 0 || range.bytes == 0 || range.instances == 0;
}

// An instance of each, the second one's moved by `shift` bytes.
bool blocks_share(const HostRange& a, const HostRange& b, std::int64_t shift) {
  const auto from = static_cast<std::int64_t>(a.offset);
  const std::int64_t to = static_cast<std::int64_t>(b.offset) + shift;
  if (from + static_cast<std::int64_t>(block_bytes(a)) <= to ||
      to + static_cast<std::int64_t>(block_bytes(b)) <= from)
    return false;
  if (a.stride != b.stride) return true;
  // Element beside element.
  const auto stride = static_cast<std::int64_t>(a.stride);
  const auto apart = static_cast<std::uint64_t>(((to - from) % stride + stride) % stride);
  return apart < a.bytes || apart + b.bytes > a.stride;
}

bool share_bytes(const HostRange& a, const HostRange& b) {
  if (is_empty(a) || is_empty(b) || a.buffer != b.buffer) return false;
  if (end_of(a) <= b.offset || end_of(b) <= a.offset) return false;
  if (a.instances == 1 && b.instances == 1) return blocks_share(a, b, 0);
  if (a.instance_stride != b.instance_stride || a.instance_stride == 0) return true;
  // Instances whose blocks can meet.
  const auto stride = static_cast<std::int64_t>(a.instance_stride);
  const std::int64_t apart =
      static_cast<std::int64_t>(a.offset) - static_cast<std::int64_t>(b.offset);
  const std::int64_t most = static_cast<std::int64_t>(std::max(a.instances, b.instances)) - 1;
  const std::int64_t first = (apart - static_cast<std::int64_t>(block_bytes(b))) / stride - 1;
  const std::int64_t last = (apart + static_cast<std::int64_t>(block_bytes(a))) / stride + 1;
  for (std::int64_t k = std::max(first, -most); k <= std::min(last, most); ++k)
    if (blocks_share(a, b, k * stride)) return true;
  return false;
}

[[noreturn]] void refuse_shared(const HostRange& a, const HostRange& b, const char* why) {
  throw Error(
      ErrorCode::InvalidArgument,
      formatted("{} and {} share bytes {} to {} of a buffer, {}; give each bytes of its own",
                a.what, b.what, std::max(a.offset, b.offset), std::min(end_of(a), end_of(b)) - 1,
                why));
}

}  // namespace

void require_apart(std::span<const HostRange> read, std::span<const HostRange> written) {
  for (const HostRange& from : read)
    for (const HostRange& to : written)
      if (share_bytes(from, to))
        refuse_shared(from, to, "so that what is read would be written over");
}

void require_apart(std::span<const HostRange> written) {
  for (std::size_t i = 0; i < written.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (share_bytes(written[k], written[i]))
        refuse_shared(written[k], written[i], "and both are written");
}

std::vector<HostRange> read_ranges(std::span<const FrameSlot> slots, const InstanceSizes& sizes,
                                   std::uint32_t instances) {
  std::vector<HostRange> ranges;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const GivenPoints& given = slots[i].given;
    const MovedPoints& moved = slots[i].moved;
    ranges.push_back({formatted("given points of slot {}", i), given.buffer, given.offset,
                      given.stride, sizes.given, kVectorBytes, given.instance_stride, instances});
    constexpr std::uint64_t kWord = sizeof(std::uint32_t);
    ranges.push_back({formatted("the list of moved points of slot {}", i), moved.buffer,
                      moved.offset, kWord, std::uint64_t{moved.max_count} + 1, kWord});
  }
  return ranges;
}

std::vector<HostRange> vertex_ranges(const VertexLayout& layout, const std::string& whose,
                                     std::uint64_t vertex_count, std::uint32_t instances) {
  const auto range = [&](const char* what, const VertexStream& stream, std::uint32_t offset,
                         VertexFormat format) {
    return HostRange{what + whose, stream.buffer,    stream.offset + offset, stream.stride,
                     vertex_count, bytes_of(format), stream.instance_stride, instances};
  };
  const VertexStream attributes = attributes_of(layout);
  std::vector<HostRange> ranges = {
      range("positions", {layout.buffer, layout.offset, layout.stride, layout.instance_stride},
            layout.position_offset, layout.position_format),
      range("normals", attributes, layout.normal_offset, layout.normal_format)};
  if (has_tangents(layout))
    ranges.push_back(range("tangents", attributes, layout.tangent_offset, layout.tangent_format));
  return ranges;
}

}  // namespace planish::vulkan
