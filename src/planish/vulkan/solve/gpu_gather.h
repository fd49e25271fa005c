#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/vulkan/embed.h"
#include "planish/vulkan/tables/device_table.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// The way from a host's points, whatever their layout, to one point for each used vertex.
class GpuGather {
 public:
  /// `vertices` holds the index of each row's point, which `row_vertices` has on the host.
  /// Instances are given.instance_stride apart, which is not 0 where there are several.
  GpuGather(Context& context, const Buffer& vertices, std::span<const std::int32_t> row_vertices,
            const GivenPoints& given, const Instances& instances = {});

  /// Within kEntryScope; a barrier from kKernelScope comes before the points are read.
  void record(VkCommandBuffer commands) const noexcept;

  /// shared::kPointFloats floats per row, instance by instance.
  [[nodiscard]] const Buffer& points() const { return points_; }

  /// Rows whose points one binding spans.
  struct Gather {
    std::int32_t first_row, row_count;
    BufferRange source;
    std::uint32_t first_vertex, shift;
  };
  [[nodiscard]] std::span<const Gather> gathers() const { return gathers_; }
  // Floats from a point to the next, and from an instance.
  [[nodiscard]] std::uint32_t source_stride() const { return source_stride_; }
  [[nodiscard]] std::uint32_t instance_floats() const { return instance_floats_; }

 private:
  void cut_gathers(std::span<const std::int32_t> row_vertices, const GivenPoints& given);
  void bind(const Buffer& vertices);

  Context& context_;
  Instances instances_;
  std::uint64_t row_count_;
  std::uint32_t source_stride_, instance_floats_;  // floats
  std::vector<Gather> gathers_;
  Buffer points_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
