#include "planish/vulkan/gpu_evaluation.h"

#include <algorithm>

#include "planish/vulkan/commands.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kVectorBytes = 3 * sizeof(float);

}  // namespace

GpuEvaluation::GpuEvaluation(Context& context, std::span<const DeviceTable> refinement,
                             const DeviceTable& limit, const Buffer& control_points,
                             const VertexLayout& layout)
    : context_(context), limit_(limit), layout_(layout) {
  constexpr std::uint32_t kFloats = shared::kPointFloats;
  const Buffer* source = &control_points;
  states_.reserve(refinement.size());
  for (const DeviceTable& table : refinement) {
    const Buffer& target =
        states_.emplace_back(context, std::uint64_t(table.row_count()) * kFloats * sizeof(float),
                             MemoryUse::Device, "planish refined points");
    refinement_.push_back({context,
                           table,
                           {source->handle(), 0, 3, kFloats},
                           {target.handle(), 0, 3, kFloats},
                           {0, table.row_count()}});
    source = &target;
  }
  std::vector<BoundKernel> bound;
  for (const DeviceTable::Slice& slice : limit.slices()) {
    const Window window = window_of(slice.rows);
    first_targets_.push_back(window.first_target);
    bound.push_back({Kernel::ApplyLimit,
                     {whole(slice.entries), whole(slice.chunks),
                      point_range(*source, slice.rows.first_source, slice.rows.source_count),
                      window.range, whole(slice.derivatives)}});
  }
  sets_ = DescriptorSets(context, bound);
}

GpuEvaluation::Window GpuEvaluation::window_of(const TableSlice& rows) const {
  const VkDeviceSize first = layout_.offset + VkDeviceSize(rows.first_row) * layout_.stride;
  const VkDeviceSize aligned = first - first % kBindingAlignment;
  const VkDeviceSize end = first + VkDeviceSize(rows.row_count - 1) * layout_.stride +
                           std::max(layout_.position_offset, layout_.normal_offset) + kVectorBytes;
  return {{layout_.buffer, aligned, end - aligned},
          static_cast<std::uint32_t>((first - aligned + layout_.position_offset) / sizeof(float))};
}

void GpuEvaluation::record(VkCommandBuffer commands) const noexcept {
  for (const StencilPass& pass : refinement_) {
    pass.record(commands);
    record_barrier(context_, commands, kKernelScope, kKernelScope);
  }
  for (std::size_t i = 0; i < limit_.slices().size(); ++i) {
    shared::TableParameters parameters = limit_.parameters(i);
    parameters.first_target = first_targets_[i];
    parameters.target_stride = layout_.stride / sizeof(float);
    // May be negative: the kernel's sum wraps around.
    parameters.normal_offset =
        layout_.normal_offset / sizeof(float) - layout_.position_offset / sizeof(float);
    limit_.record_dispatch(commands, Kernel::ApplyLimit, sets_[i], i, parameters);
    // Windows of neighbouring slices share their edge.
    record_barrier(context_, commands, kKernelScope, kKernelScope);
  }
}

}  // namespace planish::vulkan
