#pragma once

#include <cstdint>
#include <vector>

#include "planish/vulkan/device/rounds.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/patch_tables.h"

namespace planish::vulkan {

/// The rows of a surface by corner patches, straight into a host's layout. Externally synchronised;
/// tables and points outlive it.
class GpuPatches {
 public:
  /// `given`: per vertex of the mesh, where points of the state are seen from; `state`: their
  /// offsets from it, the vertex with shared::kVertexTag in the fourth float. Both of
  /// shared::kPointFloats floats. The layout's stride is at most that of the tables' limits.
  GpuPatches(Context& context, const PatchTables& tables, const Buffer& given, const Buffer& state,
             const VertexLayout& layout);

  /// Only records, within kEntryScope; all that it writes is ready for kernels.
  void record(VkCommandBuffer commands) const noexcept;
  /// The same round by round.
  Wait record_round(VkCommandBuffer commands, std::size_t round) const noexcept;
  [[nodiscard]] std::size_t round_count() const { return dispatches_.size(); }

 private:
  struct Dispatch {
    Pipeline pipeline;
    shared::CornerPatchParameters parameters;
    std::uint32_t groups;
  };

  Context& context_;
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
