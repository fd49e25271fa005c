#include "planish/vulkan/solve/gpu_solve.h"

#include <algorithm>

#include "planish/core/guards.h"
#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {
namespace {

// Based on: the paper, section 3.2, as one fused kernel a step; shaders/solve/steps.comp.

// Bounds command buffers, and the memory of partial sums.
constexpr std::uint64_t kMostSteps = 64;
constexpr std::uint64_t kPartialsBudget = 16u << 20;

// Steps return at once when an earlier one met the wanted error; every so many of them a test makes
// sure that they are not even dispatched.
constexpr std::uint32_t kStepsPerStopTest = 4;

std::uint32_t steps_that_fit(const Context& context, std::uint32_t partials_total) {
  const std::uint64_t budget = std::min(kPartialsBudget, context.max_storage_range());
  const std::uint64_t bytes_per_step = std::max<std::uint64_t>(partials_total, 1) * sizeof(float);
  return static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(budget / bytes_per_step, 1, kMostSteps));
}

}  // namespace

GpuSolve::GpuSolve(const Maker& on, const DeviceTable& masks, const GpuSolveOptions& options)
    : context_(on.context()),
      masks_(masks),
      sums_squares_(options.sums_squares),
      instances_(options.instances),
      max_steps_(options.max_steps ? options.max_steps
                                   : steps_that_fit(context_, masks.partials_total())) {
  PLANISH_ASSERT(!sums_squares_ || instances_.count == 1);
  const auto rows = static_cast<std::uint64_t>(masks.row_count());
  const std::uint64_t point_bytes = instances_.bytes(rows);
  for (Buffer& side : sides_) side = make_bindable(on, point_bytes, "planish displacement");
  initial_ = make_bindable(on, point_bytes, "planish first residual");
  const std::uint64_t step_bytes =
      std::uint64_t(max_steps_) * instances_.count * sizeof(shared::StepRecord);
  plan_ = Buffer(on, step_bytes, MemoryUse::Upload, "planish plan");
  steps_ = Buffer(on, step_bytes, MemoryUse::Device, "planish steps");
  status_ = Buffer(on, instances_.count * sizeof(shared::SolveStatus), MemoryUse::Device,
                   "planish status");
  const std::uint64_t summed_steps = sums_squares_ ? max_steps_ : 0;
  partials_ = Buffer(on, summed_steps * masks.partials_total() * sizeof(float), MemoryUse::Device,
                     "planish partial sums");
  const std::uint64_t argument_bytes = masks.slices().size() * sizeof(VkDispatchIndirectCommand);
  full_arguments_ = Buffer(on, argument_bytes, MemoryUse::Upload, "planish work groups");
  arguments_ = Buffer(on, argument_bytes, MemoryUse::Device, "planish work groups left");
  write_full_arguments();
  is_small_ = takes_all_steps();
  bind(on);
}

// On software devices barriers within a work group cost more than those between dispatches.
bool GpuSolve::takes_all_steps() const {
  if (sums_squares_ || context_.variant().read_path != ReadPath::Storage) return false;
  if (masks_.slices().size() != 1 || masks_.row_count() > std::int32_t{shared::kSmallRows})
    return false;
  const TableSlice& rows = masks_.slices()[0].rows;
  return rows.chunk_count <= shared::kSmallRows / shared::kChunkRows && rows.first_source == 0;
}

void GpuSolve::write_full_arguments() {
  std::vector<VkDispatchIndirectCommand> commands;
  for (const DeviceTable::Slice& slice : masks_.slices())
    commands.push_back({slice.group_count, instances_.count, 1});
  full_arguments_.write(std::as_bytes(std::span(commands)));
}

void GpuSolve::bind(const Maker& on) {
  const auto row_count = static_cast<std::uint64_t>(masks_.row_count());
  std::vector<BoundKernel> bound;
  for (const DeviceTable::Slice& slice : masks_.slices())
    for (std::uint32_t side = 0; side < 3; ++side) {
      const TableSlice& rows = slice.rows;
      const auto own = [&](const Buffer& points) {
        return instances_.widened(point_range(points, rows.first_row, rows.row_count), row_count);
      };
      bound.push_back(
          {Kernel::InterpolationStep,
           {whole(slice.entries), whole(slice.chunks), own(sides_[(side + 2) % 3]),
            instances_.widened(point_range(sides_[side], rows.first_source, rows.source_count),
                               row_count),
            own(initial_), own(sides_[(side + 1) % 3]), whole(steps_), whole(partials_)}});
    }
  step_sets_ = DescriptorSets(on, bound);
  std::vector<BoundKernel> finish = {{Kernel::ReduceRms, {whole(partials_), whole(steps_)}},
                                     {Kernel::FinishSolve, {whole(steps_), whole(status_)}},
                                     {Kernel::StopTest, {whole(steps_), whole(arguments_)}}};
  if (is_small_) {
    const DeviceTable::Slice& slice = masks_.slices()[0];
    finish.push_back(
        {Kernel::AllSteps,
         {whole(slice.entries), whole(slice.chunks), whole(sides_[0]), whole(sides_[1]),
          whole(sides_[2]), whole(initial_), whole(plan_), whole(status_)}});
  }
  finish_sets_ = DescriptorSets(on, finish);
}

void GpuSolve::set_plan(std::span<const StepCoefficients> steps) {
  PLANISH_ASSERT(steps.size() <= max_steps_);
  std::vector<shared::StepRecord> records;
  records.reserve(steps.size() * instances_.count);
  for (const StepCoefficients& step : steps)
    records.insert(records.end(), instances_.count,
                   {static_cast<float>(step.momentum), static_cast<float>(step.gain), 0, 0});
  plan_.write(std::as_bytes(std::span(records)));
}

void GpuSolve::record_clear(VkCommandBuffer commands) const noexcept {
  for (const Buffer& side : sides_)
    context_.vk().vkCmdFillBuffer(commands, side.handle(), 0, VK_WHOLE_SIZE, 0);
  context_.vk().vkCmdFillBuffer(commands, status_.handle(), 0, VK_WHOLE_SIZE, 0);
  record_barrier(context_, commands, kCopyScope, kEntryScope);
}

void GpuSolve::copy_plan(VkCommandBuffer commands, std::uint32_t count,
                         bool measures_last) const noexcept {
  const DeviceFunctions& vk = context_.vk();
  const std::uint64_t step_bytes = instances_.count * sizeof(shared::StepRecord);
  const std::uint64_t bytes = count * step_bytes;
  const VkBufferCopy plan{0, 0, bytes};
  if (bytes) vk.vkCmdCopyBuffer(commands, plan_.handle(), steps_.handle(), 1, &plan);
  // A step that goes nowhere still measures.
  if (measures_last) vk.vkCmdFillBuffer(commands, steps_.handle(), bytes, step_bytes, 0);
}

Wait GpuSolve::record_begin(VkCommandBuffer commands, const StepRun& run) const noexcept {
  copy_plan(commands, run.count, run.measures_last);
  const VkBufferCopy arguments{0, 0, arguments_.size()};
  context_.vk().vkCmdCopyBuffer(commands, full_arguments_.handle(), arguments_.handle(), 1,
                                &arguments);
  return {kEntryScope, kEntryScope};
}

void GpuSolve::record_plan(VkCommandBuffer commands, std::uint32_t count) const noexcept {
  copy_plan(commands, count, true);
}

void GpuSolve::record_status_of(VkCommandBuffer commands, std::uint32_t count,
                                float stop_square) const noexcept {
  shared::VectorParameters parameters{};
  parameters.stop_square = stop_square;
  parameters.count = count + 1;
  parameters.step_count = count;
  parameters.further_instances = instances_.further();
  parameters.keeps_side = 1;
  record_dispatch(context_, commands, Kernel::FinishSolve, finish_sets_[1], &parameters, 1,
                  instances_.count);
}

Wait GpuSolve::record_stop_test(VkCommandBuffer commands, const StepRun& run,
                                std::uint32_t step) const noexcept {
  shared::VectorParameters parameters{};
  parameters.step_count = step;
  parameters.count = static_cast<std::uint32_t>(masks_.slices().size());
  parameters.further_instances = instances_.further();
  parameters.stop_square = run.stop_square;
  record_dispatch(context_, commands, Kernel::StopTest, finish_sets_[2], &parameters, 1);
  return {kKernelScope, kIndirectScope};
}

Wait GpuSolve::record_step(VkCommandBuffer commands, const StepRun& run, std::uint32_t step,
                           std::size_t slice) const noexcept {
  const std::uint32_t side = (run.first_side + step) % 3;
  shared::TableParameters parameters = masks_.parameters(slice);
  parameters.step = step;
  parameters.stop_square = run.stop_square;
  parameters.further_instances = instances_.further();
  parameters.instance_rows =
      static_cast<std::uint32_t>(instances_.stride(std::uint64_t(masks_.row_count())));
  if (!sums_squares_) parameters.partials_total = 0;  // none is written
  const VkDescriptorSet set = step_sets_[3 * slice + side];
  if (run.stop_square >= 0)
    record_dispatch_indirect(context_, commands, Kernel::InterpolationStep, set, &parameters,
                             {arguments_.handle(), slice * sizeof(VkDispatchIndirectCommand)});
  else
    masks_.record_dispatch(commands, Kernel::InterpolationStep, set, slice, parameters,
                           instances_.count);
  // Also between slices: all of them raise the same maximum.
  return kKernelWait;
}

Wait GpuSolve::record_end(VkCommandBuffer commands, const StepRun& run,
                          std::uint32_t round) const noexcept {
  shared::VectorParameters parameters{};
  parameters.stop_square = run.stop_square;
  const std::uint32_t measured = run.count + (run.measures_last ? 1 : 0);
  if (sums_squares_ && round == 0) {
    parameters.count = masks_.partials_total();
    record_dispatch(context_, commands, Kernel::ReduceRms, finish_sets_[0], &parameters, measured);
    return kKernelWait;
  }
  if (round > (sums_squares_ ? 1u : 0u)) return {};
  parameters.count = measured;
  parameters.step_count = run.count;
  parameters.first_side = run.first_side;
  parameters.further_instances = instances_.further();
  record_dispatch(context_, commands, Kernel::FinishSolve, finish_sets_[1], &parameters, 1,
                  instances_.count);
  return {kKernelScope, kEntryScope};
}

Wait GpuSolve::record_all_steps(VkCommandBuffer commands, const StepRun& run) const noexcept {
  shared::AllStepsParameters parameters{};
  parameters.chunk_count = masks_.parameters(0).chunk_count;
  parameters.instance_rows =
      static_cast<std::uint32_t>(instances_.stride(std::uint64_t(masks_.row_count())));
  parameters.instances = instances_.count;
  parameters.step_count = run.count;
  parameters.measured = run.count + (run.measures_last ? 1 : 0);
  parameters.first_side = run.first_side;
  parameters.stop_square = run.stop_square;
  record_dispatch(context_, commands, Kernel::AllSteps, finish_sets_[3], &parameters, 1,
                  instances_.count);
  return {kKernelScope, kEntryScope};
}

Wait GpuSolve::record_round(VkCommandBuffer commands, const StepRun& run,
                            std::uint32_t round) const noexcept {
  if (is_small_) {
    // Of the first round others write what the steps read.
    if (round == 0) return kKernelWait;
    return round == 1 ? record_all_steps(commands, run) : Wait{};
  }
  if (round == 0) return record_begin(commands, run);
  const auto slices = static_cast<std::uint32_t>(masks_.slices().size());
  const std::uint32_t measured = run.count + (run.measures_last ? 1 : 0);
  const bool tests = run.stop_square >= 0;
  const std::uint32_t test_count = tests ? (measured - 1) / kStepsPerStopTest : 0;
  const std::uint32_t end = 1 + measured * slices + test_count;
  if (round >= end) return record_end(commands, run, round - end);
  // Some steps of a round for each slice and then a test, as often as there are steps.
  const std::uint32_t period = kStepsPerStopTest * slices + (tests ? 1 : 0);
  const std::uint32_t first_step = (round - 1) / period * kStepsPerStopTest;
  const std::uint32_t place = (round - 1) % period;
  if (place == kStepsPerStopTest * slices)
    return record_stop_test(commands, run, first_step + kStepsPerStopTest);
  return record_step(commands, run, first_step + place / slices, place % slices);
}

void GpuSolve::record_steps(VkCommandBuffer commands, const StepRun& run) const noexcept {
  record_rounds(context_, commands, 1, [&](std::size_t, std::uint32_t round) {
    return record_round(commands, run, round);
  });
}

}  // namespace planish::vulkan
