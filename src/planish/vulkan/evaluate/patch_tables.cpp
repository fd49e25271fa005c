#include "planish/vulkan/evaluate/patch_tables.h"

namespace planish::vulkan {

namespace {

// Items that one binding spans.
template <class Items>
Buffer make_whole(const Maker& on, const Items& items, const char* name) {
  return make_bindable(on, std::as_bytes(std::span(items)).size(), name);
}

// Items of which bindings span windows: only all of them together may be more than a limit.
template <class Items>
Buffer make_windowed(const Maker& on, const Items& items, const char* name) {
  return {on, std::as_bytes(std::span(items)).size(), MemoryUse::Device, name};
}

}  // namespace

PatchLimits patch_limits(const Context& context, std::uint32_t row_stride) {
  PatchLimits limits;
  limits.range = context.binding_limit();
  limits.max_units = std::uint64_t(context.max_group_count()) * context.variant().chunks_per_group;
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
      links(make_whole(on, records.links, "planish corner links")),
      groups(make_whole(on, records.groups, "planish patch groups")),
      words(make_windowed(on, records.words, "planish patch words")),
      weights(make_windowed(on, records.weights, "planish patch weights")),
      rings(make_whole(on, records.rings, "planish rings")) {}

StepTables::StepTables(const Maker& on, const StepRecords& records)
    : parts(records.parts),
      rule(records.rule),
      vertices(make_whole(on, records.vertices, "planish corner vertices")),
      words(make_whole(on, records.words, "planish step words")) {}

BufferRange window_range(const Buffer& items, const IndexWindow& window, std::uint64_t item_bytes) {
  if (window.count == 0) return {items.handle(), 0, item_bytes};
  return {items.handle(), static_cast<std::uint64_t>(window.first) * item_bytes,
          static_cast<std::uint64_t>(window.count) * item_bytes};
}

}  // namespace planish::vulkan
