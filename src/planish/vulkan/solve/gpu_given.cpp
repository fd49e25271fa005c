// Based on: the paper, section 3.2: the iteration starts from the given points, so that its first
// residual is D^0 = V0 - B V0; in terms of the displacement, from zero or from the last frame's.
#include "planish/vulkan/solve/gpu_given.h"

namespace planish::vulkan {

GpuGiven::GpuGiven(Context& context, const DeviceTable& masks, const GpuSolve& solve,
                   const Buffer& vertices, std::span<const std::int32_t> row_vertices,
                   const GivenPoints& given)
    : context_(context),
      masks_(masks),
      pieces_(cut_rows(context, masks.row_count(), kPointBytes)),
      gather_(context, vertices, row_vertices, given),
      control_(context, masks.row_count() * kPointBytes, MemoryUse::Device,
               "planish control points"),
      moved_(context, masks.row_count() * kPointBytes, MemoryUse::Device,
             "planish last displacement") {
  bind(solve);
}

void GpuGiven::bind(const GpuSolve& solve) {
  std::vector<BoundKernel> bound;
  const auto own = [](const Buffer& points, const VectorPiece& piece) {
    return point_range(points, piece.first_row, piece.row_count);
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
    bound.push_back(
        {Kernel::InitialResidual,
         {whole(slice.entries), whole(slice.chunks),
          point_range(gather_.points(), slice.rows.first_source, slice.rows.source_count),
          point_range(solve.initial(), slice.rows.first_row, slice.rows.row_count)}});
  sets_ = DescriptorSets(context_, bound);
}

void GpuGiven::record_pieces(VkCommandBuffer commands, Kernel kernel, std::size_t first_set,
                             bool warm_start) const noexcept {
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    shared::VectorParameters parameters{};
    parameters.count = static_cast<std::uint32_t>(pieces_[i].row_count);
    parameters.warm = warm_start ? 1 : 0;
    record_dispatch(context_, commands, kernel, sets_[first_set + i], &parameters,
                    pieces_[i].group_count);
  }
}

Wait GpuGiven::record_points(VkCommandBuffer commands, bool warm_start) const noexcept {
  gather_.record(commands);
  record_pieces(commands, Kernel::TakeUp, 0, warm_start);
  return kKernelWait;
}

Wait GpuGiven::record_residual(VkCommandBuffer commands) const noexcept {
  const std::size_t first_set = 2 * pieces_.size();
  for (std::size_t i = 0; i < masks_.slices().size(); ++i)
    masks_.record_dispatch(commands, Kernel::InitialResidual, sets_[first_set + i], i,
                           masks_.parameters(i));
  return kKernelWait;
}

void GpuGiven::record_control_points(VkCommandBuffer commands) const noexcept {
  record_pieces(commands, Kernel::ControlPoints, pieces_.size(), false);
}

}  // namespace planish::vulkan
