#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>

#include "planish/vulkan/host/frame_parts.h"

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
            layout.position_offset, layout.position_format)};
  if (has_normals(layout))
    ranges.push_back(range("normals", attributes, layout.normal_offset, layout.normal_format));
  if (has_tangents(layout))
    ranges.push_back(range("tangents", attributes, layout.tangent_offset, layout.tangent_format));
  return ranges;
}

namespace {

// Work groups that every device has in y.
constexpr std::uint32_t kMostInstances = 65535;

bool is_word(VkDeviceSize value) { return value % sizeof(float) == 0; }

void check_given(const GivenPoints& given) {
  require_option(is_word(given.offset) && is_word(given.stride) && given.stride >= kVectorBytes,
                 "given points lie at multiples of 4 bytes, 12 or more apart");
}

void check_formats(const VertexLayout& layout) {
  using enum VertexFormat;
  require_option(layout.position_format <= Snorm16x4,
                 "positions are Float3, Half4 or Snorm16x4, not of a format for normals");
  require_option(layout.normal_format == Float3 || layout.normal_format == Octahedral16 ||
                     layout.normal_format == Snorm10,
                 "normals are Float3, Octahedral16 or Snorm10, not of a format for positions");
  require_option(layout.tangent_format == Float4 || layout.tangent_format == Snorm10,
                 "tangents are Float4 or Snorm10, not of another format");
  for (std::size_t k = 0; k < 3; ++k)
    require_option(std::isfinite(layout.box_center[k]) && std::isfinite(layout.box_half[k]) &&
                       layout.box_half[k] > 0,
                   "the box of compact positions has a centre of finite numbers and "
                   "halves above 0, not {}",
                   std::to_string(layout.box_half[k]));
}

void check_holds(std::uint32_t stride, std::uint32_t offset, std::uint32_t bytes) {
  require_option(offset <= stride && stride - offset >= bytes,
                 "a vertex of stride {} does not hold {} bytes from offset {} on", stride, bytes,
                 offset);
}

void check_tangents(const VertexLayout& layout, bool has_tables) {
  if (!has_tangents(layout)) return;
  require_option(
      has_tables,
      "the System has no tangents; make it textured, of a mesh with texture coordinates");
  require_option(has_normals(layout), "tangents are square to normals; give these an offset, too");
  require_option(is_word(layout.tangent_offset), "tangents lie at multiples of 4 bytes");
  check_holds(attributes_of(layout).stride, layout.tangent_offset, bytes_of(layout.tangent_format));
}

void check_moved(const MovedPoints& moved, bool has_tables) {
  if (!moved.buffer) return;
  require_option(has_tables, "the DeviceSystem has no tables for edits; make it with takes_edits");
  require_option(moved.max_count > 0,
                 "the list of moved points has a max_count of 0; give its largest");
  require_option(moved.offset % sizeof(std::uint32_t) == 0,
                 "the list of moved points begins at {}, which is no multiple of 4 bytes",
                 moved.offset);
}

// Of instances together: `bytes`, of which one has `each`.
struct Span {
  const char* what;
  std::uint64_t bytes, each;
};

void check_span(const Context& context, std::uint32_t instances, const Span& span) {
  const std::uint64_t fit = std::max<std::uint64_t>(context.max_storage_range() / span.each, 1);
  const std::string what = formatted("{} of {}", span.what, instances);
  require_binding(context, span.bytes, what + " instances",
                  formatted("make Solves of at most {} instances", fit));
}

void check_instance_stride(VkDeviceSize stride, std::uint64_t needed) {
  require_option(stride >= needed,
                 "vertices of an instance take {} bytes, but the next one's begin after {}", needed,
                 stride);
}

void check_strides(const FrameSlot& slot, std::uint64_t vertex_count) {
  const VertexLayout& layout = slot.vertices;
  const VertexStream attributes = attributes_of(layout);
  require_option(is_word(slot.given.instance_stride) && is_word(layout.instance_stride) &&
                     is_word(attributes.instance_stride),
                 "strides between instances are multiples of 4 bytes");
  if (!layout.buffer || vertex_count == 0) return;
  check_instance_stride(layout.instance_stride, (vertex_count - 1) * layout.stride +
                                                    layout.position_offset +
                                                    bytes_of(layout.position_format));
  const std::uint32_t normal =
      has_normals(layout) ? layout.normal_offset + bytes_of(layout.normal_format) : 0;
  const std::uint32_t tangent =
      has_tangents(layout) ? layout.tangent_offset + bytes_of(layout.tangent_format) : 0;
  check_instance_stride(attributes.instance_stride,
                        (vertex_count - 1) * attributes.stride + std::max(normal, tangent));
}

void check_spans(const Context& context, std::uint32_t count, const FrameSlot& slot) {
  const auto check = [&](const char* what, std::uint64_t stride) {
    if (stride > 0) check_span(context, count, {what, count * stride + kBindingAlignment, stride});
  };
  check("given points", slot.given.instance_stride);
  if (!slot.vertices.buffer) return;
  check("vertices", slot.vertices.instance_stride);
  check("attributes", attributes_of(slot.vertices).instance_stride);
}

FrameSlot with_strides(const InstanceSizes& sizes, FrameSlot slot) {
  check_given(slot.given);
  if (!slot.given.buffer) slot.given.offset = 0, slot.given.stride = kVectorBytes;
  if (!slot.given.buffer || slot.given.instance_stride == 0)
    slot.given.instance_stride = sizes.given * slot.given.stride;
  check_moved(slot.moved, sizes.takes_edits);
  VertexLayout& vertices = slot.vertices;
  if (vertices.buffer) check_layout(vertices, sizes);
  if (vertices.instance_stride == 0) vertices.instance_stride = sizes.vertices * vertices.stride;
  if (vertices.attributes.buffer && vertices.attributes.instance_stride == 0)
    vertices.attributes.instance_stride = sizes.vertices * vertices.attributes.stride;
  require_option(
      !slot.moved.buffer || !vertices.buffer || attributes_of(vertices).buffer == vertices.buffer,
      "a slot that takes edits has positions and attributes in one buffer");
  return slot;
}

// What an evaluation writes is read by no solve or edit, of whatever slot. Slots may share
// vertices.
void check_ranges(std::span<const FrameSlot> slots, const InstanceSizes& sizes,
                  std::uint32_t instances) {
  const std::vector<HostRange> read = read_ranges(slots, sizes, instances);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const std::vector<HostRange> written =
        vertex_ranges(slots[i].vertices, formatted(" of slot {}", i), sizes.vertices, instances);
    require_apart(written);
    require_apart(read, written);
  }
}

// Vectors of several instances, beside those of the slots.
void check_vectors(const Context& context, const InstanceSizes& sizes,
                   const SolveOptions& options) {
  const Instances instances{options.instances};
  const std::uint32_t count = options.instances;
  const std::uint64_t step_bytes =
      (std::uint64_t(options.max_iterations) + 1) * sizeof(shared::StepRecord);
  const std::uint64_t row_bytes = instances.bytes(sizes.rows) / count;
  const std::uint64_t point_bytes = instances.bytes(sizes.points) / count;
  check_span(context, count, {"points", count * row_bytes, std::max<std::uint64_t>(row_bytes, 1)});
  if (sizes.has_surface)
    check_span(context, count,
               {"points of level 1", count * point_bytes, std::max<std::uint64_t>(point_bytes, 1)});
  check_span(context, count, {"steps", count * step_bytes, step_bytes});
}

}  // namespace

void check_layout(const VertexLayout& layout, const InstanceSizes& sizes) {
  const VertexStream attributes = attributes_of(layout);
  require_option(is_word(layout.offset) && is_word(layout.stride) &&
                     is_word(layout.position_offset) &&
                     (!has_normals(layout) || is_word(layout.normal_offset)) &&
                     is_word(attributes.offset) && is_word(attributes.stride),
                 "offsets and strides of a vertex layout are multiples of 4 bytes");
  check_formats(layout);
  check_holds(layout.stride, layout.position_offset, bytes_of(layout.position_format));
  if (has_normals(layout))
    check_holds(attributes.stride, layout.normal_offset, bytes_of(layout.normal_format));
  check_tangents(layout, sizes.has_tangents);
  const std::uint32_t largest = std::max(layout.stride, attributes.stride);
  require_option(
      largest <= sizes.max_vertex_stride,
      "the stride {} of a vertex layout is above {}, the DeviceSystem's max_vertex_stride", largest,
      sizes.max_vertex_stride);
}

std::vector<FrameSlot> checked_slots(const Context& context, const InstanceSizes& sizes,
                                     const SolveOptions& options) {
  const std::uint32_t count = options.instances;
  require_option(count >= 1 && count <= kMostInstances, "instances {} are outside 1 to {}", count,
                 kMostInstances);
  std::vector<FrameSlot> slots = {{options.given, options.vertices, options.moved}};
  slots.insert(slots.end(), options.further_slots.begin(), options.further_slots.end());
  require_option(slots.size() <= kMostSlots,
                 "{} slots are more than {}, the frames in flight that a Solve serves",
                 slots.size(), kMostSlots);
  for (FrameSlot& slot : slots) slot = with_strides(sizes, slot);
  require_option(count == 1 || !sizes.is_fair,
                 "Solves of the fair method have one instance, not {}; "
                 "make as many Solves and take record_solves()",
                 count);
  if (count > 1) {
    for (const FrameSlot& slot : slots) check_strides(slot, sizes.vertices);
    check_vectors(context, sizes, options);
    for (const FrameSlot& slot : slots) check_spans(context, count, slot);
  }
  check_ranges(slots, sizes, count);
  return slots;
}

}  // namespace planish::vulkan
