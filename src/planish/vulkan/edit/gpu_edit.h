#pragma once

#include <array>
#include <cstdint>

#include "planish/vulkan/edit/edit_tables.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/gpu_first_step.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/gpu_ring_sums.h"
#include "planish/vulkan/solve/gpu_given.h"
#include "planish/vulkan/solve/gpu_solve.h"

namespace planish::vulkan {

/// What an edit works on besides its own: what solves and evaluations of all points left.
struct EditedParts {
  const DeviceTable& masks;
  const Buffer& vertices;  ///< of the rows
  const EditTables& edits;
  const PatchTables& patches;
  const StepTables& steps;
  const GpuSolve& solve;
  const GpuGiven& given;
  const GpuFirstStep& step;
  const GpuRingSums* sums;  ///< or null
};

/// Moves some of the points that a surface passes through: solves and evaluates what they reach.
/// Externally synchronised; all that it was made of outlives it.
class GpuEdit {
 public:
  /// `layout` without a buffer: no vertices. Throws Error{OutOfMemory} naming the limit.
  GpuEdit(Context& context, const EditedParts& parts, const MovedPoints& moved,
          std::int32_t given_count, const VertexLayout& layout);

  /// No row is in a list, as edits leave it: before the first of them. A copy, to be waited for.
  void record_clear(VkCommandBuffer commands) const noexcept;
  /// At most as many steps as the solve's plan has. Begins and ends within kEntryScope and
  /// kExitScope.
  void record(VkCommandBuffer commands, std::uint32_t step_count, float stop_square) const noexcept;

  /// A buffer that begins with the words of an EditReach.
  [[nodiscard]] VkBuffer reach() const { return work_.handle(); }

 private:
  enum Stage { Begin, Take, Residual, Advance, Commit, Jobs, Points };
  static constexpr std::size_t kStages = 7;

  [[nodiscard]] BufferRange moves_range(const MovedPoints& moved);
  void fill_parameters(std::int32_t given_count);
  void make_work();
  void bind(const MovedPoints& moved);
  void wait(VkCommandBuffer commands) const noexcept;

  Context& context_;
  EditedParts parts_;
  Instances instances_;
  shared::EditParameters parameters_{};
  std::array<Pipeline, kStages> pipelines_;
  Buffer template_;  // what the work's words begin with
  Buffer work_, flags_, velocity_;
  DescriptorSets sets_;
  std::optional<GpuPatches> evaluation_;
};

}  // namespace planish::vulkan
