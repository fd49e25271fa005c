#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/gpu_first_step.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/gpu_ring_sums.h"
#include "planish/vulkan/levels/level_tables.h"

namespace planish::vulkan {

/// What levels are chosen by and evaluated from: what a solve left.
struct ChosenParts {
  const PatchTables& patches;  ///< of the System's own level
  const StepTables* steps;     ///< of the progressive method, with `step`
  const LevelSetTables& set;
  const Buffer& hull;        ///< points around the surface, instance by instance
  std::uint64_t hull_count;  ///< of one instance
  std::uint64_t hull_stride;
  const Buffer &given, &state;
  std::uint64_t vertex_count;
  Instances instances;
  const GpuFirstStep* step;  ///< of all instances
};

/// Chooses a level for each instance, and evaluates those that are seen. Externally synchronised;
/// all that it was made of outlives it.
class GpuLevels {
 public:
  /// `options` are whole: a number of places for each level. Throws Error{OutOfMemory} naming the
  /// limit.
  GpuLevels(const Maker& on, const ChosenParts& parts, const TessellationOptions& options);

  /// Within kEntryScope; a fill, to be waited for.
  void record_reset(VkCommandBuffer commands) const noexcept;
  /// Within kEntryScope, behind the points of the hull; ends in kExitScope.
  void record(VkCommandBuffer commands, const TessellateParameters& view) const noexcept;

  /// Words: of each instance the level that the view wants, then those that there was room for.
  [[nodiscard]] VkBuffer levels() const { return levels_.handle(); }
  [[nodiscard]] VkBuffer draws() const { return draws_.handle(); }

 private:
  enum Set { Choose, PlaceAll };
  struct Words;

  void make_work(const Maker& on, const TessellationOptions& options);
  void make_surface(const Maker& on, const Words& words);
  void make_patches(const Maker& on, const TessellationOptions& options, const Words& words);
  void record_choice(VkCommandBuffer commands, const TessellateParameters& view) const noexcept;
  [[nodiscard]] IndirectGroups groups_of(std::size_t segment) const noexcept {
    return {work_.handle(),
            first_segment_ + segment * shared::kChosenWords * sizeof(std::uint32_t)};
  }
  void wait(VkCommandBuffer commands) const noexcept;

  Context& context_;
  ChosenParts parts_;
  shared::ChooseParameters choose_{};
  shared::PlaceInstancesParameters place_{};
  Pipeline choose_pipeline_, place_pipeline_;
  VkDeviceSize first_segment_ = 0;  // bytes
  Buffer template_, work_, levels_, draws_;
  std::optional<GpuFirstStep> step_;
  std::optional<GpuRingSums> sums_;
  std::deque<GpuPatches> patches_;  // of each level
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
