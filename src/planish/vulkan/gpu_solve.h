#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planish/vulkan/device_table.h"

namespace planish::vulkan {

/// Work buffers and written descriptor sets of one interpolation on the device. The displacement
/// goes round in three buffers, its sides: a step reads two and writes the third, so that a stop
/// leaves both what the result needs and what going on needs. Externally synchronised; the table
/// outlives it. Recording cannot fail, and only records.
class GpuSolve {
 public:
  /// `masks` was made with includes_own_rows. Throws Error{OutOfMemory} naming the limit.
  GpuSolve(Context& context, const DeviceTable& masks);

  /// Steps that one record_steps can hold.
  [[nodiscard]] std::uint32_t max_steps() const { return max_steps_; }

  /// Momentum and gain of the steps to come; max_steps() of them, the rest of a record zero. Read
  /// by the device whenever recorded steps run; flush_plan() after writing.
  [[nodiscard]] std::span<shared::StepRecord> plan();
  void flush_plan() { plan_.flush(); }

  /// Displacement and step = 0.
  void record_clear(VkCommandBuffer commands) const noexcept;

  /// Steps 0..count-1 of the plan, from side `first_side`; none once an error is <= the square
  /// root of `stop_square` (negative: never). Fills steps() and status(). Begins and ends within
  /// kEntryScope and kExitScope.
  void record_steps(VkCommandBuffer commands, std::uint32_t first_side, std::uint32_t count,
                    float stop_square) const noexcept;

  /// shared::kPointFloats floats per row.
  [[nodiscard]] const Buffer& side(std::uint32_t i) const { return sides_[i]; }
  [[nodiscard]] const Buffer& initial() const { return initial_; }
  /// shared::StepRecord per step, and shared::SolveStatus.
  [[nodiscard]] const Buffer& steps() const { return steps_; }
  [[nodiscard]] const Buffer& status() const { return status_; }

 private:
  void bind(Context& context);

  Context& context_;
  const DeviceTable& masks_;
  std::uint32_t max_steps_ = 0;
  std::array<Buffer, 3> sides_;
  Buffer initial_, plan_, steps_, status_, partials_;
  DescriptorSets step_sets_;    // slice * 3 + side
  DescriptorSets finish_sets_;  // reduce_rms, finish_solve
};

}  // namespace planish::vulkan
