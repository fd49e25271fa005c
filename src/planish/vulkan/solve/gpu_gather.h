#pragma once

#include <cstddef>
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

  /// Rows whose points one binding spans.
  struct Gather {
    std::int32_t first_row, row_count;
    BufferRange source;
    std::uint32_t first_vertex, shift;
    std::uint32_t source_stride, instance_floats;  // from a point to the next, from an instance
  };
  [[nodiscard]] std::span<const Gather> gathers(std::uint32_t slot) const {
    return std::span(gathers_).subspan(firsts_[slot], firsts_[slot + 1] - firsts_[slot]);
  }

 private:
  void cut_gathers(std::span<const std::int32_t> row_vertices, const GivenPoints& given);
  void bind(const Maker& on, const Buffer& vertices);

  Context& context_;
  Instances instances_;
  std::uint64_t row_count_;
  std::vector<Gather> gathers_;      // slot by slot
  std::vector<std::size_t> firsts_;  // of each slot, and their number
  Buffer points_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
