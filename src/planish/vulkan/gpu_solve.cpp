// Based on: the paper, section 3.2, as one fused kernel a step; shaders/interpolation_step.comp.
#include "planish/vulkan/gpu_solve.h"

#include <algorithm>

#include "planish/vulkan/commands.h"

namespace planish::vulkan {

namespace {

// Bounds command buffers, and the memory of partial sums.
constexpr std::uint64_t kMostSteps = 64;
constexpr std::uint64_t kPartialsBudget = 16u << 20;

std::uint32_t steps_that_fit(const Context& context, std::uint32_t partials_total) {
  const std::uint64_t budget = std::min(kPartialsBudget, context.max_storage_range());
  const std::uint64_t bytes_per_step = std::max<std::uint64_t>(partials_total, 1) * sizeof(float);
  return static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(budget / bytes_per_step, 1, kMostSteps));
}

}  // namespace

GpuSolve::GpuSolve(Context& context, const DeviceTable& masks)
    : context_(context),
      masks_(masks),
      max_steps_(steps_that_fit(context, masks.partials_total())) {
  const std::uint64_t point_bytes =
      std::uint64_t(masks.row_count()) * shared::kPointFloats * sizeof(float);
  for (Buffer& side : sides_) side = Buffer(context, point_bytes, MemoryUse::Device);
  initial_ = Buffer(context, point_bytes, MemoryUse::Device);
  const std::uint64_t step_bytes = max_steps_ * sizeof(shared::StepRecord);
  plan_ = Buffer(context, step_bytes, MemoryUse::Upload);
  steps_ = Buffer(context, step_bytes, MemoryUse::Device);
  status_ = Buffer(context, sizeof(shared::SolveStatus), MemoryUse::Device);
  partials_ = Buffer(context, std::uint64_t(max_steps_) * masks.partials_total() * sizeof(float),
                     MemoryUse::Device);
  bind(context);
}

void GpuSolve::bind(Context& context) {
  std::vector<BoundKernel> bound;
  for (const DeviceTable::Slice& slice : masks_.slices())
    for (std::uint32_t side = 0; side < 3; ++side) {
      const TableSlice& rows = slice.rows;
      const auto own = [&](const Buffer& points) {
        return point_range(points, rows.first_row, rows.row_count);
      };
      bound.push_back(
          {Kernel::InterpolationStep,
           {whole(slice.entries), whole(slice.chunks), own(sides_[(side + 2) % 3]),
            point_range(sides_[side], rows.first_source, rows.source_count), own(initial_),
            own(sides_[(side + 1) % 3]), whole(steps_), whole(partials_)}});
    }
  step_sets_ = DescriptorSets(context, bound);
  const BoundKernel finish[] = {{Kernel::ReduceRms, {whole(partials_), whole(steps_)}},
                                {Kernel::FinishSolve, {whole(steps_), whole(status_)}}};
  finish_sets_ = DescriptorSets(context, finish);
}

std::span<shared::StepRecord> GpuSolve::plan() {
  return {reinterpret_cast<shared::StepRecord*>(plan_.mapped().data()), max_steps_};
}

void GpuSolve::record_clear(VkCommandBuffer commands) const noexcept {
  for (const Buffer& side : sides_)
    context_.vk().vkCmdFillBuffer(commands, side.handle(), 0, VK_WHOLE_SIZE, 0);
  record_barrier(context_, commands, kCopyScope, kEntryScope);
}

void GpuSolve::record_steps(VkCommandBuffer commands, std::uint32_t first_side, std::uint32_t count,
                            float stop_square) const noexcept {
  const VkBufferCopy copy{0, 0, steps_.size()};
  context_.vk().vkCmdCopyBuffer(commands, plan_.handle(), steps_.handle(), 1, &copy);
  record_barrier(context_, commands, kEntryScope, kKernelScope);

  for (std::uint32_t step = 0; step < count; ++step) {
    const std::uint32_t side = (first_side + step) % 3;
    for (std::size_t i = 0; i < masks_.slices().size(); ++i) {
      shared::TableParameters parameters = masks_.parameters(i);
      parameters.step = step;
      parameters.stop_square = stop_square;
      masks_.record_dispatch(commands, Kernel::InterpolationStep, step_sets_[3 * i + side], i,
                             parameters);
      // Also between slices: all of them raise the same maximum.
      record_barrier(context_, commands, kKernelScope, kKernelScope);
    }
  }

  shared::VectorParameters parameters{};
  parameters.stop_square = stop_square;
  parameters.count = masks_.partials_total();
  record_dispatch(context_, commands, Kernel::ReduceRms, finish_sets_[0], &parameters, count);
  record_barrier(context_, commands, kKernelScope, kKernelScope);
  parameters.count = count;
  parameters.first_side = first_side;
  record_dispatch(context_, commands, Kernel::FinishSolve, finish_sets_[1], &parameters, 1);
  record_barrier(context_, commands, kKernelScope, kEntryScope);
}

}  // namespace planish::vulkan
