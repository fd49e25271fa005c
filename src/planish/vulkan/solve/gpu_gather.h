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
  /// `vertices` holds the index of each row's point, which `row_vertices` has on the host; `given`
  /// has a host's points for each slot. Instances are given.instance_stride apart, which is not 0
  /// where there are several.
  GpuGather(const Maker& on, const Buffer& vertices, std::span<const std::int32_t> row_vertices,
            std::span<const GivenPoints> given, const Instances& instances = {});

  /// Of a slot's points. Within kEntryScope; a barrier from kKernelScope comes before the points
  /// are read.
  void record(VkCommandBuffer commands, std::uint32_t slot) const noexcept;

  /// shared::kPointFloats floats per row, instance by instance.
  [[nodiscard]] const Buffer& points() const { return points_; }

  /// A slot's points, as its binding has them.
  struct Source {
    BufferRange range;
    std::uint32_t shift;                    // floats between the range's start and point 0
    std::uint32_t stride, instance_floats;  // from a point to the next, from an instance
  };
  [[nodiscard]] const Source& source(std::uint32_t slot) const { return sources_[slot]; }

 private:
  [[nodiscard]] Source source_of(std::int32_t last_vertex, const GivenPoints& given) const;

  Context& context_;
  Instances instances_;
  std::uint64_t row_count_;
  std::vector<Source> sources_;
  Buffer points_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
