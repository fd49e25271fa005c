// Based on: the paper, section 3.2: the iteration starts from the given points, so that its first
// residual is D^0 = V0 - B V0; in terms of the displacement, from zero or from the last frame's.
#include "planish/vulkan/solve/gpu_given.h"

namespace planish::vulkan {

GpuGiven::GpuGiven(const Maker& on, const DeviceTable& masks, const GpuSolve& solve,
                   const Buffer& vertices, std::span<const std::int32_t> row_vertices,
                   std::span<const GivenPoints> given)
    : context_(on.context()),
      masks_(masks),
      instances_(solve.instances()),
      row_count_(static_cast<std::uint64_t>(masks.row_count())),
      pieces_(cut_rows(context_, masks.row_count(), kPointBytes)),
      gather_(on, vertices, row_vertices, given, instances_),
      control_(on, instances_.bytes(row_count_), MemoryUse::Device, "planish control points"),
      moved_(on, instances_.bytes(row_count_), MemoryUse::Device, "planish last displacement") {
  bind(on, solve);
}

void GpuGiven::bind(const Maker& on, const GpuSolve& solve) {
  std::vector<BoundKernel> bound;
  const auto range = [&](const Buffer& points, std::int32_t first, std::int32_t count) {
    return instances_.widened(point_range(points, first, count), row_count_);
  };
  const auto own = [&](const Buffer& points, const VectorPiece& piece) {
    return range(points, piece.first_row, piece.row_count);
  };
  for (const VectorPiece& piece : pieces_)
    bound.push_back({Kernel::TakeUp,
                     {own(solve.side(0), piece), own(solve.side(1), piece),
                      own(solve.side(2), piece), whole(solve.status())}});
  for (const VectorPiece& piece : pieces_)
    bound.push_back({Kernel::ControlPoints,
                     {own(solve.side(0), piece), own(solve.side(1), piece),
                      own(solve.side(2), piece), whole(solve.status()),
                      own(gather_.points(), piece), own(control_, piece), own(moved_, piece)}});
  for (const DeviceTable::Slice& slice : masks_.slices())
    bound.push_back({Kernel::InitialResidual,
                     {whole(slice.entries), whole(slice.chunks),
                      range(gather_.points(), slice.rows.first_source, slice.rows.source_count),
                      range(solve.initial(), slice.rows.first_row, slice.rows.row_count)}});
  sets_ = DescriptorSets(on, bound);
}

// Windows of several instances overlap.
void GpuGiven::separate(VkCommandBuffer commands, std::size_t part) const noexcept {
  if (part > 0 && instances_.count > 1)
    record_barrier(context_, commands, kKernelScope, kKernelScope);
}

void GpuGiven::record_pieces(VkCommandBuffer commands, Kernel kernel, std::size_t first_set,
                             bool warm_start) const noexcept {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    separate(commands, i);
    shared::VectorParameters parameters{};
    parameters.count = static_cast<std::uint32_t>(pieces_[i].row_count);
    parameters.warm = warm_start ? 1 : 0;
    parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
    record_dispatch(context_, commands, kernel, sets_[first_set + i], &parameters,
                    pieces_[i].group_count, instances_.count);
  }
}

Wait GpuGiven::record_points(VkCommandBuffer commands, bool warm_start,
                             std::uint32_t slot) const noexcept {
  gather_.record(commands, slot);
  record_pieces(commands, Kernel::TakeUp, 0, warm_start);
  return kKernelWait;
}

Wait GpuGiven::record_residual(VkCommandBuffer commands) const noexcept {
  const std::size_t first_set = 2 * pieces_.size();
  for (std::size_t i = 0; i < masks_.slices().size(); ++i) {
    separate(commands, i);
    shared::TableParameters parameters = masks_.parameters(i);
    parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
    masks_.record_dispatch(commands, Kernel::InitialResidual, sets_[first_set + i], i, parameters,
                           instances_.count);
  }
  return kKernelWait;
}

void GpuGiven::record_control_points(VkCommandBuffer commands) const noexcept {
  record_pieces(commands, Kernel::ControlPoints, pieces_.size(), false);
}

}  // namespace planish::vulkan
