// Based on: the paper, section 3.2: the iteration starts from the given points, so that its first
// residual is D^0 = V0 - B V0; in terms of the displacement, from zero or from the last frame's.
#include "planish/vulkan/gpu_given.h"

#include <algorithm>
#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/commands.h"

namespace planish::vulkan {

namespace {

constexpr std::int32_t kLanes = 64;
constexpr std::uint64_t kPointBytes = shared::kPointFloats * sizeof(float);

}  // namespace

GpuGiven::GpuGiven(Context& context, const DeviceTable& masks, const GpuSolve& solve,
                   const Buffer& vertices, std::span<const std::int32_t> row_vertices,
                   const GivenPoints& given)
    : context_(context),
      masks_(masks),
      source_stride_(given.stride / sizeof(float)),
      pieces_(cut_rows(context, masks.row_count(), kPointBytes)),
      given_(context, masks.row_count() * kPointBytes, MemoryUse::Device, "planish given points"),
      control_(context, masks.row_count() * kPointBytes, MemoryUse::Device,
               "planish control points") {
  cut_gathers(row_vertices, given);
  bind(solve, vertices);
}

void GpuGiven::cut_gathers(std::span<const std::int32_t> row_vertices, const GivenPoints& given) {
  const std::uint64_t range = context_.max_storage_range();
  const std::uint64_t most_rows =
      std::min(range / kPointBytes / kLanes, std::uint64_t(context_.max_group_count())) * kLanes;
  const auto window = [&](std::size_t first, std::size_t end) {
    const VkDeviceSize start = given.offset + VkDeviceSize(row_vertices[first]) * given.stride;
    const VkDeviceSize aligned = start - start % kBindingAlignment;
    const VkDeviceSize bytes =
        start - aligned + 3 * sizeof(float) +
        VkDeviceSize(row_vertices[end - 1] - row_vertices[first]) * given.stride;
    return BufferRange{given.buffer, aligned, bytes};
  };
  for (std::size_t first = 0; first < row_vertices.size();) {
    // Whole groups of rows, as far as one binding spans their points.
    std::size_t end = first;
    while (end < row_vertices.size() && end - first < std::max<std::uint64_t>(most_rows, kLanes)) {
      const std::size_t next = std::min(end + kLanes, row_vertices.size());
      if (end > first && window(first, next).size > range) break;
      end = next;
    }
    const BufferRange source = window(first, end);
    if (source.size > range)
      throw Error(ErrorCode::OutOfMemory,
                  "given points from " + std::to_string(row_vertices[first]) + " on span " +
                      std::to_string(source.size) + " bytes, but maxStorageBufferRange is " +
                      std::to_string(range) + "; use a smaller stride",
                  row_vertices[first]);
    const VkDeviceSize start = given.offset + VkDeviceSize(row_vertices[first]) * given.stride;
    gathers_.push_back({static_cast<std::int32_t>(first), static_cast<std::int32_t>(end - first),
                        source, static_cast<std::uint32_t>(row_vertices[first]),
                        static_cast<std::uint32_t>((start - source.offset) / sizeof(float))});
    first = end;
  }
}

void GpuGiven::bind(const GpuSolve& solve, const Buffer& vertices) {
  std::vector<BoundKernel> bound;
  for (const Gather& gather : gathers_)
    bound.push_back({Kernel::GatherPoints,
                     {{vertices.handle(), std::uint64_t(gather.first_row) * sizeof(std::uint32_t),
                       std::uint64_t(gather.row_count) * sizeof(std::uint32_t)},
                      gather.source,
                      point_range(given_, gather.first_row, gather.row_count)}});
  const auto own = [](const Buffer& points, const VectorPiece& piece) {
    return point_range(points, piece.first_row, piece.row_count);
  };
  for (const VectorPiece& piece : pieces_)
    bound.push_back({Kernel::TakeUp,
                     {own(solve.side(0), piece), own(solve.side(1), piece),
                      own(solve.side(2), piece), whole(solve.status())}});
  for (const VectorPiece& piece : pieces_)
    bound.push_back(
        {Kernel::ControlPoints,
         {own(solve.side(0), piece), own(solve.side(1), piece), own(solve.side(2), piece),
          whole(solve.status()), own(given_, piece), own(control_, piece)}});
  for (const DeviceTable::Slice& slice : masks_.slices())
    bound.push_back({Kernel::InitialResidual,
                     {whole(slice.entries), whole(slice.chunks),
                      point_range(given_, slice.rows.first_source, slice.rows.source_count),
                      point_range(solve.initial(), slice.rows.first_row, slice.rows.row_count)}});
  sets_ = DescriptorSets(context_, bound);
}

void GpuGiven::record_gather(VkCommandBuffer commands) const noexcept {
  for (std::size_t i = 0; i < gathers_.size(); ++i) {
    const Gather& gather = gathers_[i];
    shared::VectorParameters parameters{};
    parameters.count = static_cast<std::uint32_t>(gather.row_count);
    parameters.first_vertex = gather.first_vertex;
    parameters.source_shift = gather.shift;
    parameters.source_stride = source_stride_;
    record_dispatch(context_, commands, Kernel::GatherPoints, sets_[i], &parameters,
                    static_cast<std::uint32_t>((gather.row_count + kLanes - 1) / kLanes));
  }
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

void GpuGiven::record_begin(VkCommandBuffer commands, bool warm_start) const noexcept {
  record_gather(commands);
  record_pieces(commands, Kernel::TakeUp, gathers_.size(), warm_start);
  record_barrier(context_, commands, kKernelScope, kKernelScope);
  const std::size_t first_set = gathers_.size() + 2 * pieces_.size();
  for (std::size_t i = 0; i < masks_.slices().size(); ++i)
    masks_.record_dispatch(commands, Kernel::InitialResidual, sets_[first_set + i], i,
                           masks_.parameters(i));
  record_barrier(context_, commands, kKernelScope, kKernelScope);
}

void GpuGiven::record_control_points(VkCommandBuffer commands) const noexcept {
  record_pieces(commands, Kernel::ControlPoints, gathers_.size() + pieces_.size(), false);
  record_barrier(context_, commands, kKernelScope, kKernelScope);
}

}  // namespace planish::vulkan
