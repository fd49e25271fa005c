// Based on: M. R. Hestenes and E. Stiefel, "Methods of conjugate gradients for solving linear
// systems", 1952, with one alpha and beta per coordinate.
#include "planish/vulkan/solve/gpu_conjugate_gradients.h"

#include <algorithm>

#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

GpuConjugateGradients::GpuConjugateGradients(Context& context, const DeviceTable& masks)
    : context_(context), masks_(masks) {
  const std::uint64_t scalar_bytes = std::uint64_t(masks.row_count()) * sizeof(float);
  for (Buffer* vector : {&displacement_, &step_, &image_, &residual_})
    *vector = make_bindable(context, shared::kPointFloats * scalar_bytes, "planish gradients");
  weights_ = Buffer(context, scalar_bytes, MemoryUse::Device);
  row_groups_ = row_groups(static_cast<std::uint64_t>(masks.row_count()));
  const std::uint64_t sum_bytes = shared::kSumFloats * sizeof(std::uint32_t);
  partials_ =
      Buffer(context, std::max(row_groups_, masks.group_total()) * sum_bytes, MemoryUse::Device);
  sums_ = Buffer(context, sum_bytes, MemoryUse::Device);
  bind(context);
}

void GpuConjugateGradients::bind(Context& context) {
  const auto weight_range = [&](const TableSlice& rows) {
    return BufferRange{weights_.handle(), std::uint64_t(rows.first_row) * sizeof(float),
                       std::uint64_t(rows.row_count) * sizeof(float)};
  };
  std::vector<BoundKernel> bound;
  for (const DeviceTable::Slice& slice : masks_.slices()) {
    const TableSlice& rows = slice.rows;
    bound.push_back({Kernel::CgApply,
                     {whole(slice.entries), whole(slice.chunks),
                      point_range(step_, rows.first_source, rows.source_count),
                      point_range(image_, rows.first_row, rows.row_count), weight_range(rows),
                      whole(partials_)}});
  }
  bound.push_back({Kernel::CgAdvance,
                   {whole(displacement_), whole(step_), whole(residual_), whole(image_),
                    whole(weights_), whole(partials_)}});
  bound.push_back({Kernel::CgTurn, {whole(step_), whole(residual_)}});
  bound.push_back({Kernel::ReduceSums, {whole(partials_), whole(sums_)}});
  sets_ = DescriptorSets(context, bound);
}

void GpuConjugateGradients::record_begin(VkCommandBuffer commands) const noexcept {
  const DeviceFunctions& vk = context_.vk();
  vk.vkCmdFillBuffer(commands, displacement_.handle(), 0, VK_WHOLE_SIZE, 0);
  // An advance before the first apply, by alpha = 0, must not meet a NaN.
  vk.vkCmdFillBuffer(commands, image_.handle(), 0, VK_WHOLE_SIZE, 0);
  const VkBufferCopy copy{0, 0, residual_.size()};
  vk.vkCmdCopyBuffer(commands, residual_.handle(), step_.handle(), 1, &copy);
  record_barrier(context_, commands, kCopyScope, kEntryScope);
}

void GpuConjugateGradients::record_apply(VkCommandBuffer commands) const noexcept {
  for (std::size_t i = 0; i < masks_.slices().size(); ++i) {
    const shared::TableParameters parameters = masks_.parameters(i);
    masks_.record_dispatch(commands, Kernel::CgApply, sets_[i], i, parameters);
    record_barrier(context_, commands, kKernelScope, kKernelScope);
  }
  record_reduce(commands, masks_.group_total());
}

void GpuConjugateGradients::record_advance(VkCommandBuffer commands,
                                           const glm::vec3& alpha) const noexcept {
  record_rows(commands, Kernel::CgAdvance, kAdvance, alpha);
  record_reduce(commands, row_groups_);
}

void GpuConjugateGradients::record_turn(VkCommandBuffer commands,
                                        const glm::vec3& beta) const noexcept {
  record_rows(commands, Kernel::CgTurn, kTurn, beta);
}

void GpuConjugateGradients::record_rows(VkCommandBuffer commands, Kernel kernel, BehindMasks set,
                                        const glm::vec3& factor) const noexcept {
  shared::VectorParameters parameters{};
  parameters.count = static_cast<std::uint32_t>(masks_.row_count());
  parameters.x = factor.x;
  parameters.y = factor.y;
  parameters.z = factor.z;
  record_dispatch(context_, commands, kernel, sets_[masks_.slices().size() + set], &parameters,
                  row_groups_);
  record_barrier(context_, commands, kKernelScope, kEntryScope);
}

void GpuConjugateGradients::record_reduce(VkCommandBuffer commands,
                                          std::uint32_t group_count) const noexcept {
  shared::VectorParameters parameters{};
  parameters.count = group_count;
  record_dispatch(context_, commands, Kernel::ReduceSums, sets_[masks_.slices().size() + kReduce],
                  &parameters, 1);
  record_barrier(context_, commands, kKernelScope, kEntryScope);
}

}  // namespace planish::vulkan
