#include "planish/vulkan/solve/gpu_gather.h"

#include <algorithm>
#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

namespace {

constexpr std::int32_t kGatherLanes = 64;

}  // namespace

GpuGather::GpuGather(const Maker& on, const Buffer& vertices,
                     std::span<const std::int32_t> row_vertices, std::span<const GivenPoints> given,
                     const Instances& instances)
    : context_(on.context()),
      instances_(instances),
      row_count_(row_vertices.size()),
      points_(on, instances.bytes(row_count_), MemoryUse::Device, "planish given points") {
  for (const GivenPoints& slot : given) {
    firsts_.push_back(gathers_.size());
    cut_gathers(row_vertices, slot);
  }
  firsts_.push_back(gathers_.size());
  bind(on, vertices);
}

void GpuGather::cut_gathers(std::span<const std::int32_t> row_vertices, const GivenPoints& given) {
  const std::uint64_t range = context_.max_storage_range();
  const std::uint64_t most_rows =
      std::min(range / kPointBytes / kGatherLanes, std::uint64_t(context_.max_group_count())) *
      kGatherLanes;
  const auto window = [&](std::size_t first, std::size_t end) {
    const VkDeviceSize start = given.offset + VkDeviceSize(row_vertices[first]) * given.stride;
    const VkDeviceSize aligned = start - start % kBindingAlignment;
    const VkDeviceSize bytes =
        start - aligned + 3 * sizeof(float) +
        VkDeviceSize(row_vertices[end - 1] - row_vertices[first]) * given.stride +
        instances_.further() * given.instance_stride;
    return BufferRange{given.buffer, aligned, bytes};
  };
  for (std::size_t first = 0; first < row_vertices.size();) {
    // Whole groups of rows, as far as one binding spans their points.
    std::size_t end = first;
    while (end < row_vertices.size() &&
           end - first < std::max<std::uint64_t>(most_rows, kGatherLanes)) {
      const std::size_t next = std::min(end + kGatherLanes, row_vertices.size());
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
                        static_cast<std::uint32_t>((start - source.offset) / sizeof(float)),
                        static_cast<std::uint32_t>(given.stride / sizeof(float)),
                        static_cast<std::uint32_t>(given.instance_stride / sizeof(float))});
    first = end;
  }
}

void GpuGather::bind(const Maker& on, const Buffer& vertices) {
  std::vector<BoundKernel> bound;
  for (const Gather& gather : gathers_)
    bound.push_back({Kernel::GatherPoints,
                     {{vertices.handle(), std::uint64_t(gather.first_row) * sizeof(std::uint32_t),
                       std::uint64_t(gather.row_count) * sizeof(std::uint32_t)},
                      gather.source,
                      instances_.widened(point_range(points_, gather.first_row, gather.row_count),
                                         row_count_)}});
  sets_ = DescriptorSets(on, bound);
}

void GpuGather::record(VkCommandBuffer commands, std::uint32_t slot) const noexcept {
  for (std::size_t i = firsts_[slot]; i < firsts_[slot + 1]; ++i) {
    const Gather& gather = gathers_[i];
    // Windows of instances overlap.
    if (i > firsts_[slot] && instances_.count > 1)
      record_barrier(context_, commands, kKernelScope, kKernelScope);
    shared::VectorParameters parameters{};
    parameters.count = static_cast<std::uint32_t>(gather.row_count);
    parameters.first_vertex = gather.first_vertex;
    parameters.source_shift = gather.shift;
    parameters.source_stride = gather.source_stride;
    parameters.instance_rows = static_cast<std::uint32_t>(instances_.stride(row_count_));
    parameters.instance_floats = gather.instance_floats;
    record_dispatch(
        context_, commands, Kernel::GatherPoints, sets_[i], &parameters,
        static_cast<std::uint32_t>((gather.row_count + kGatherLanes - 1) / kGatherLanes),
        instances_.count);
  }
}

}  // namespace planish::vulkan
