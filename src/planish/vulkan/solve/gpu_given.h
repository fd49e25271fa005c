#pragma once

#include <cstdint>
#include <span>

#include "planish/vulkan/device/rounds.h"
#include "planish/vulkan/solve/gpu_gather.h"
#include "planish/vulkan/solve/gpu_solve.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

/// The way from a host's points to a solve's right-hand side and start, and from its displacement
/// to control points. Externally synchronised; solve and tables outlive it.
class GpuGiven {
 public:
  /// For the solve's instances. `vertices` holds the index of each row's point, which
  /// `row_vertices` has on the host; `given` has a host's points for each slot.
  GpuGiven(const Maker& on, const DeviceTable& masks, const GpuSolve& solve, const Buffer& vertices,
           std::span<const std::int32_t> row_vertices, std::span<const GivenPoints> given);

  /// Points of a slot, and the displacement from the last one or zero; within kEntryScope.
  Wait record_points(VkCommandBuffer commands, bool warm_start, std::uint32_t slot) const noexcept;
  /// Then the right-hand side from the points.
  Wait record_residual(VkCommandBuffer commands) const noexcept;
  /// control_points() = given() + displacement(). Within kEntryScope; kKernelWait comes after it.
  void record_control_points(VkCommandBuffer commands) const noexcept;

  // Of shared::kPointFloats floats per row, instance by instance.
  [[nodiscard]] const Buffer& given() const { return gather_.points(); }
  [[nodiscard]] const Buffer& displacement() const { return moved_; }
  [[nodiscard]] const Buffer& control_points() const { return control_; }
  [[nodiscard]] const GpuGather& gather() const { return gather_; }

 private:
  void bind(const Maker& on, const GpuSolve& solve);
  void record_rows(VkCommandBuffer commands, Kernel kernel, std::size_t set,
                   bool warm_start) const noexcept;

  Context& context_;
  const DeviceTable& masks_;
  Instances instances_;
  std::uint64_t row_count_;
  GpuGather gather_;
  Buffer control_, moved_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
