#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planish/patches/patch_mesh.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/solve/gpu_given.h"
#include "planish/vulkan/solve/gpu_solve.h"

namespace planish::vulkan {

/// What edits must know of a mesh beside what all frames do. Lists of a vertex: words [v] to
/// [v + 1] say where it begins and ends among all words.
struct EditRecords {
  std::vector<std::uint32_t> slots;   ///< per row of the limit masks, DeviceTable::slots()
  std::vector<std::uint32_t> places;  ///< lists: corners at the vertex, points that it owns beside
                                      ///< sharp edges and at corner vertices
  std::vector<std::uint32_t> jobs;    ///< lists: patches whose points its faces have, ascending
  std::uint64_t job_count = 0;        ///< lanes of all groups of patches
};

/// `patches` were made of `mesh`, with their owners. Throws Error{OutOfMemory} where words do not
/// count the jobs.
[[nodiscard]] EditRecords edit_records(const PatchMesh& mesh, const PatchRecords& patches,
                                       std::vector<std::uint32_t> slots);

/// EditRecords on a device. Read-only after its upload ran.
struct EditTables {
  /// Throws Error{OutOfMemory} naming the limit that a table exceeds.
  EditTables(const Maker& on, const EditRecords& records);

  std::uint64_t job_count;
  Buffer slots, places, jobs;

  /// Calls take(buffer, bytes) for all of them, in one order.
  template <class Take>
  void for_each(const EditRecords& records, const Take& take) const {
    const auto bytes = [](const auto& items) { return std::as_bytes(std::span(items)); };
    take(slots, bytes(records.slots));
    take(places, bytes(records.places));
    take(jobs, bytes(records.jobs));
  }
};

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
  /// Slots without a list of moved points take no edits, those without vertices write none. Throws
  /// Error{OutOfMemory} naming the limit.
  GpuEdit(const Maker& on, const EditedParts& parts, std::int32_t given_count,
          std::span<const FrameSlot> slots);

  /// Whether a slot takes edits.
  [[nodiscard]] bool has_list(std::uint32_t slot) const { return slots_[slot].has_list; }
  /// No row is in a list, nor stale in any slot: before the first edit. A copy, to be waited for.
  void record_clear(VkCommandBuffer commands) const noexcept;
  /// Of a slot's list, which it has; at most as many steps as the solve's plan has. Begins and ends
  /// within kEntryScope and kExitScope.
  void record(VkCommandBuffer commands, std::uint32_t slot, std::uint32_t step_count,
              float stop_square) const noexcept;

  /// A buffer that begins with the words of an EditReach.
  [[nodiscard]] VkBuffer reach() const { return work_.handle(); }

 private:
  /// The last two have sets of each slot.
  enum Stage { Residual, Advance, Commit, Points, Stale, Jobs, Begin, Take };
  static constexpr std::size_t kStages = 8;
  static constexpr std::size_t kSlotStages = 2;

  /// What the kernels of a slot's edits are given; the list's range is of one binding.
  struct Slot {
    bool has_list;
    shared::EditParameters parameters;
    BufferRange moves;
    std::optional<GpuPatches> evaluation;
  };

  [[nodiscard]] shared::EditParameters common_parameters(std::int32_t given_count) const;
  void make_slot(const Maker& on, const FrameSlot& slot, std::uint32_t number,
                 const shared::EditParameters& common);
  void make_work(const Maker& on, shared::EditParameters& parameters);
  void bind(const Maker& on);
  [[nodiscard]] VkDescriptorSet set_of(Stage stage, std::uint32_t slot) const {
    return sets_[stage + (stage < Begin ? 0U : kSlotStages * slot)];
  }
  void wait(VkCommandBuffer commands) const noexcept;

  Context& context_;
  EditedParts parts_;
  Instances instances_;
  std::array<Pipeline, kStages> pipelines_;
  std::uint64_t head_bytes_ = 0;  // of the work's words
  Buffer template_;               // what those begin with, then the heads of stale lists
  Buffer work_, flags_, velocity_, stale_;
  std::vector<Slot> slots_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
