#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/solve/backend.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

/// The largest float whose square root, in double, is at most `stop_error`, so that the kernel's
/// comparison and one of the reported errors agree. Negative: never stop.
[[nodiscard]] inline float stop_square_of(double stop_error) noexcept {
  if (!(stop_error >= 0)) return -1;
  auto square = static_cast<float>(stop_error * stop_error);
  while (std::sqrt(static_cast<double>(square)) > stop_error)
    square = std::nextafter(square, -1.0f);
  return std::max(square, 0.0f);
}

struct GpuSolveOptions {
  /// Steps that one record_steps can hold, measuring included; 0: as many as suit batches.
  std::uint32_t max_steps = 0;
  bool sums_squares = true;  ///< false: StepRecord::square_sum stays 0, which saves memory
  Instances instances;       ///< one where squares are summed
};

/// What record_steps records.
struct StepRun {
  std::uint32_t first_side = 0;
  std::uint32_t count = 0;
  float stop_square = -1;      ///< no step once |error|^2 is at most this; negative: never stop
  bool measures_last = false;  ///< measures what the last step left, as one more step
};

/// Work buffers and written descriptor sets of one interpolation on the device. The displacement
/// goes round in three buffers, its sides: a step reads two and writes the third, so that a stop
/// leaves both what the result needs and what going on needs. Of small instances one dispatch takes
/// all steps, with a work group each, and leaves the plan's copies as they are. Externally
/// synchronised; the table outlives it. Recording cannot fail, and only records.
class GpuSolve {
 public:
  /// `masks` was made with includes_own_rows. Throws Error{OutOfMemory} naming the limit.
  GpuSolve(const Maker& on, const DeviceTable& masks, const GpuSolveOptions& options = {});

  /// Steps that one record_steps can hold.
  [[nodiscard]] std::uint32_t max_steps() const { return max_steps_; }

  /// Momentum and gain of the steps to come, at most max_steps() of them. Read by the device
  /// whenever recorded steps run.
  void set_plan(std::span<const StepCoefficients> steps);

  /// Displacement and step = 0, and a status of zeros.
  void record_clear(VkCommandBuffer commands) const noexcept;

  /// Steps 0..count-1 of the plan, and status() at their end; count + measures_last is 1 to
  /// max_steps(). Fills steps() and status(). Begins and ends within kEntryScope and kExitScope.
  void record_steps(VkCommandBuffer commands, const StepRun& run) const noexcept;
  /// The same round by round. The first one only copies, from and to buffers of this solve's own.
  Wait record_round(VkCommandBuffer commands, const StepRun& run,
                    std::uint32_t round) const noexcept;

  /// The first `count` steps of the plan and one that only measures, for who takes them itself:
  /// copies, to be waited for.
  void record_plan(VkCommandBuffer commands, std::uint32_t count) const noexcept;
  /// Then status() as those steps left it, but for the side.
  void record_status_of(VkCommandBuffer commands, std::uint32_t count,
                        float stop_square) const noexcept;

  [[nodiscard]] const Instances& instances() const { return instances_; }
  /// shared::kPointFloats floats per row, instance by instance.
  [[nodiscard]] const Buffer& side(std::uint32_t i) const { return sides_[i]; }
  [[nodiscard]] const Buffer& initial() const { return initial_; }
  /// shared::StepRecord per step and instance, and shared::SolveStatus per instance.
  [[nodiscard]] const Buffer& steps() const { return steps_; }
  [[nodiscard]] const Buffer& status() const { return status_; }

 private:
  void bind(const Maker& on);
  [[nodiscard]] bool takes_all_steps() const;
  Wait record_all_steps(VkCommandBuffer commands, const StepRun& run) const noexcept;
  void write_full_arguments();
  void copy_plan(VkCommandBuffer commands, std::uint32_t count, bool measures_last) const noexcept;
  Wait record_begin(VkCommandBuffer commands, const StepRun& run) const noexcept;
  Wait record_step(VkCommandBuffer commands, const StepRun& run, std::uint32_t step,
                   std::size_t slice) const noexcept;
  Wait record_stop_test(VkCommandBuffer commands, const StepRun& run,
                        std::uint32_t step) const noexcept;
  Wait record_end(VkCommandBuffer commands, const StepRun& run, std::uint32_t round) const noexcept;

  Context& context_;
  const DeviceTable& masks_;
  bool sums_squares_ = true;
  Instances instances_;
  std::uint32_t max_steps_ = 0;
  std::array<Buffer, 3> sides_;
  Buffer initial_, plan_, steps_, status_, partials_;
  DescriptorSets step_sets_;    // slice * 3 + side
  Buffer full_arguments_;       // of the indirect dispatches, one per slice
  Buffer arguments_;            // the same, until an error is low enough
  DescriptorSets finish_sets_;  // reduce_rms, finish_solve, stop_test; all_steps if they are
  bool is_small_ = false;       // one dispatch takes all steps, and writes the status
};

}  // namespace planish::vulkan
