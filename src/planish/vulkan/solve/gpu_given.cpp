// Based on: the paper, section 3.2: the iteration starts from the given points, so that its first
// residual is D^0 = V0 - B V0; in terms of the displacement, from zero or from the last frame's.
#include "planish/vulkan/solve/gpu_given.h"

namespace planish::vulkan {

namespace {

enum : std::size_t { kTakeUp, kControlPoints, kMasks };  // sets; of each slice of the masks

}  // namespace

GpuGiven::GpuGiven(const Maker& on, const DeviceTable& masks, const GpuSolve& solve,
                   const Buffer& vertices, std::span<const std::int32_t> row_vertices,
                   std::span<const GivenPoints> given)
    : context_(on.context()),
      masks_(masks),
      instances_(solve.instances()),
      row_count_(static_cast<std::uint64_t>(masks.row_count())),
      gather_(on, vertices, row_vertices, given, instances_),
      control_(make_bindable(on, instances_.bytes(row_count_), "planish control points")),
      moved_(make_bindable(on, instances_.bytes(row_count_), "planish last displacement")) {
  bind(on, solve);
}

void GpuGiven::bind(const Maker& on, const GpuSolve& solve) {
  std::vector<BoundKernel> bound;
  const auto range = [&](const Buffer& points, std::int32_t first, std::int32_t count) {
    return instances_.widened(point_range(points, first, count), row_count_);
  };
  const auto status = whole(solve.status());
  const auto side = [&](std::uint32_t i) { return whole(solve.side(i)); };
  bound.push_back({Kernel::TakeUp, {side(0), side(1), side(2), status}});
  bound.push_back({Kernel::ControlPoints,
                   {side(0), side(1), side(2), status, whole(gather_.points()), whole(control_),
                    whole(moved_)}});
  for (const DeviceTable::Slice& slice : masks_.slices())
    bound.push_back({Kernel::InitialResidual,
                     {whole(slice.entries), whole(slice.chunks),
                      range(gather_.points(), slice.rows.first_source, slice.rows.source_count),
                      range(solve.initial(), slice.rows.first_row, slice.rows.row_count)}});
  sets_ = DescriptorSets(on, bound);
}

void GpuGiven::record_rows(VkCommandBuffer commands, Kernel kernel, std::size_t set,
                           bool warm_start) const noexcept {
  shared::VectorParameters parameters{};
  parameters.count = static_cast<std::uint32_t>(row_count_);
  parameters.warm = warm_start ? 1 : 0;
  parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
  record_dispatch(context_, commands, kernel, sets_[set], &parameters, row_groups(row_count_),
                  instances_.count);
}

Wait GpuGiven::record_points(VkCommandBuffer commands, bool warm_start,
                             std::uint32_t slot) const noexcept {
  gather_.record(commands, slot);
  record_rows(commands, Kernel::TakeUp, kTakeUp, warm_start);
  return kKernelWait;
}

Wait GpuGiven::record_residual(VkCommandBuffer commands) const noexcept {
  for (std::size_t i = 0; i < masks_.slices().size(); ++i) {
    // Windows of several instances overlap.
    if (i > 0 && instances_.count > 1)
      record_barrier(context_, commands, kKernelScope, kKernelScope);
    shared::TableParameters parameters = masks_.parameters(i);
    parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
    masks_.record_dispatch(commands, Kernel::InitialResidual, sets_[kMasks + i], i, parameters,
                           instances_.count);
  }
  return kKernelWait;
}

void GpuGiven::record_control_points(VkCommandBuffer commands) const noexcept {
  record_rows(commands, Kernel::ControlPoints, kControlPoints, false);
}

}  // namespace planish::vulkan
