#pragma once

#include <cstdint>

#include "planish/vulkan/device/rounds.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// The sums of large rings, behind the state of level 1 as GpuPatches reads it. Externally
/// synchronised; tables and points outlive it.
class GpuRingSums {
 public:
  /// `tables` have rings, and `state` has room for PatchTables::point_count points an instance;
  /// `given` and `vertex_count` as in GpuPatches.
  GpuRingSums(const Maker& on, const PatchTables& tables, const Buffer& given, const Buffer& state,
              std::uint64_t vertex_count = 0, const Instances& instances = {},
              const InstanceList& listed = {});

  /// Only records, within kEntryScope: the one round.
  Wait record(VkCommandBuffer commands) const noexcept;
  /// The same of listed instances, and its work groups in x.
  Wait record_listed(VkCommandBuffer commands, const IndirectGroups& groups) const noexcept;
  [[nodiscard]] std::uint32_t group_count() const { return groups_; }

 private:
  Context& context_;
  Instances instances_;
  Pipeline pipeline_;
  shared::RingSumParameters parameters_{};
  std::uint32_t groups_ = 0;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
