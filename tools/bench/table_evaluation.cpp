#include "bench/table_evaluation.h"

#include <algorithm>

#include "planish/vulkan/device/commands.h"

namespace planish::bench {

using namespace vulkan;

namespace {

constexpr std::uint32_t kWrittenFloats = 3;

// The host's vertices as far as they are written.
FloatElements written_elements(const VertexLayout& layout) {
  const std::uint32_t last = std::max(layout.position_offset, layout.normal_offset);
  return {layout.buffer, layout.offset / sizeof(float),
          static_cast<std::uint32_t>(last / sizeof(float)) + kWrittenFloats,
          static_cast<std::uint32_t>(layout.stride / sizeof(float))};
}

}  // namespace

TableEvaluation::TableEvaluation(Context& context, std::span<const DeviceTable> refinement,
                                 const DeviceTable& limit, VkBuffer control_points,
                                 const VertexLayout& layout)
    : context_(context), limit_(limit), layout_(layout) {
  constexpr std::uint32_t kFloats = shared::kPointFloats;
  VkBuffer source = control_points;
  states_.reserve(refinement.size());
  for (const DeviceTable& table : refinement) {
    const Buffer& target = states_.emplace_back(
        context, std::uint64_t(table.row_count()) * kFloats * sizeof(float), MemoryUse::Device);
    refinement_.push_back({context,
                           table,
                           {source, 0, 3, kFloats},
                           {target.handle(), 0, 3, kFloats},
                           {0, table.row_count()}});
    source = target.handle();
  }
  std::vector<BoundKernel> bound;
  for (const DeviceTable::Slice& slice : limit.slices()) {
    const ElementWindow window =
        element_window(written_elements(layout), slice.rows.first_row, slice.rows.row_count);
    first_targets_.push_back(window.shift +
                             static_cast<std::uint32_t>(layout.position_offset / sizeof(float)));
    bound.push_back({Kernel::ApplyLimit,
                     {whole(slice.entries), whole(slice.chunks),
                      point_range(states_.back(), slice.rows.first_source, slice.rows.source_count),
                      window.range, whole(slice.derivatives)}});
  }
  sets_ = DescriptorSets(context, bound);
}

void TableEvaluation::record(VkCommandBuffer commands) const noexcept {
  for (const StencilPass& pass : refinement_) {
    pass.record(commands);
    record_barrier(context_, commands, kKernelScope, kKernelScope);
  }
  for (std::size_t i = 0; i < limit_.slices().size(); ++i) {
    shared::TableParameters parameters = limit_.parameters(i);
    parameters.first_target = first_targets_[i];
    parameters.target_stride = layout_.stride / sizeof(float);
    parameters.normal_offset =
        layout_.normal_offset / sizeof(float) - layout_.position_offset / sizeof(float);
    limit_.record_dispatch(commands, Kernel::ApplyLimit, sets_[i], i, parameters);
    // Windows of neighbouring slices share their edge.
    record_barrier(context_, commands, kKernelScope, kKernelScope);
  }
}

}  // namespace planish::bench
