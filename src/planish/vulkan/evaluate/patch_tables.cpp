#include "planish/vulkan/evaluate/patch_tables.h"

#include <string>

#include "planish/core/error.h"

namespace planish::vulkan {

namespace {

// Of texels as the kernel's binding has them.
template <class Items>
Buffer make_patch_buffer(const Maker& on, const Items& items, std::uint64_t texel_bytes,
                         const char* name) {
  const Context& context = on.context();
  const std::uint64_t bytes = std::as_bytes(std::span(items)).size();
  if (bytes / texel_bytes > context.max_texel_elements())
    throw Error(ErrorCode::OutOfMemory, context.capabilities().name + ": " + name + " have " +
                                            std::to_string(bytes / texel_bytes) +
                                            " texels, but maxTexelBufferElements is " +
                                            std::to_string(context.max_texel_elements()) +
                                            "; use --device cpu, a lower level or a smaller mesh");
  return make_bindable(on, bytes, name);
}

// Items of which bindings span windows: only all of them together may be more than a limit.
template <class Items>
Buffer make_windowed(const Maker& on, const Items& items, const char* name) {
  return {on, std::as_bytes(std::span(items)).size(), MemoryUse::Device, name};
}

}  // namespace

PatchLimits patch_limits(const Context& context, std::uint32_t row_stride) {
  PatchLimits limits;
  limits.max_range = context.max_storage_range();
  limits.max_elements = context.max_texel_elements();
  limits.max_groups = context.max_group_count();
  limits.max_units = limits.max_groups * context.variant().chunks_per_group;
  limits.row_stride = row_stride;
  limits.joins_ways = context.variant().read_path == ReadPath::Storage;
  return limits;
}

PatchTables::PatchTables(const Maker& on, const PatchRecords& records, std::int64_t points)
    : point_count(points),
      ring_count(records.ring_count),
      has_frames(records.has_frames),
      first_sum(records.first_sum),
      slices(records.slices),
      links(make_windowed(on, records.links, "planish corner links")),
      groups(
          make_patch_buffer(on, records.groups, 4 * sizeof(std::uint32_t), "planish patch groups")),
      words(make_windowed(on, records.words, "planish patch words")),
      weights(make_windowed(on, records.weights, "planish patch weights")),
      rings(make_patch_buffer(on, records.rings, sizeof(std::uint32_t), "planish rings")) {}

StepTables::StepTables(const Maker& on, const StepRecords& records)
    : slices(records.slices),
      rule(records.rule),
      vertices(make_windowed(on, records.vertices, "planish corner vertices")),
      words(make_patch_buffer(on, records.words, sizeof(std::uint32_t), "planish step words")) {}

BufferRange window_range(const Buffer& items, const IndexWindow& window, std::uint64_t item_bytes) {
  if (window.count == 0) return {items.handle(), 0, item_bytes};
  return {items.handle(), static_cast<std::uint64_t>(window.first) * item_bytes,
          static_cast<std::uint64_t>(window.count) * item_bytes};
}

}  // namespace planish::vulkan
