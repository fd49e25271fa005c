#pragma once

#include <cstdint>
#include <memory>

#include "planish/vulkan/device/rounds.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// The first step on the device: from given points and their displacement to the state of level 1
/// as GpuPatches reads it. Externally synchronised; tables and points outlive it.
class GpuFirstStep {
 public:
  /// `given`, `displacement`: shared::kPointFloats floats for each of `vertex_count` vertices,
  /// instance by instance.
  GpuFirstStep(const Maker& on, const PatchTables& patches, const StepTables& tables,
               const Buffer& given, const Buffer& displacement, std::uint64_t vertex_count = 0,
               const Instances& instances = {});
  /// Some instances of another one's points, into its state.
  GpuFirstStep(const Maker& on, const PatchTables& patches, const StepTables& tables,
               const GpuFirstStep& all, const InstanceList& listed);

  /// Only records, within kEntryScope; all that it writes is ready for kernels.
  void record(VkCommandBuffer commands) const noexcept;
  /// The same round by round.
  Wait record_round(VkCommandBuffer commands, std::size_t round) const noexcept;
  [[nodiscard]] std::size_t round_count() const { return dispatches_.size(); }
  /// A round of listed instances, and its work groups in x; those in y are as many as instances.
  Wait record_listed(VkCommandBuffer commands, std::size_t round,
                     const IndirectGroups& groups) const noexcept;
  [[nodiscard]] std::uint32_t group_count(std::size_t round) const {
    return dispatches_[round].groups;
  }
  /// Those rounds that make the points of large faces, each with the barrier behind it.
  void record_large_faces(VkCommandBuffer commands) const noexcept;

  /// shared::kPointFloats floats per point, instance by instance.
  [[nodiscard]] const Buffer& state() const { return *points_.state; }

 private:
  struct Dispatch {
    Pipeline pipeline;
    shared::FirstStepParameters parameters;
    std::uint32_t groups;
    bool is_of_large;
  };

  /// What it reads and writes.
  struct Points {
    const Buffer *given, *displacement;
    std::uint64_t vertex_count;
    const Buffer* state;
  };
  void bind(const Maker& on, const PatchTables& patches, const StepTables& tables,
            const InstanceList& listed);

  Context& context_;
  Instances instances_;
  std::unique_ptr<Buffer> own_state_;  // where it is no other one's
  Points points_;
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
