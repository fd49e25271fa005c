#pragma once

#include <cstdint>
#include <vector>

#include "planish/vulkan/device/rounds.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// Patches that kernels list: a segment for each of the tables' slices, see shaders/shared.h.
struct ListedPatches {
  const Buffer* work = nullptr;  ///< null: all patches are done
  std::uint32_t first_segment = shared::kEditHeadWords;
  std::uint32_t job_count = 0;
};

/// The rows of a surface by corner patches, straight into a host's layout. Externally synchronised;
/// tables and points outlive it.
class GpuPatches {
 public:
  /// `given`: per vertex of the mesh, where points of the state are seen from; `state`: their
  /// offsets from it, the vertex with shared::kVertexTag in the fourth float. Both of
  /// shared::kPointFloats floats, instance by instance, `vertex_count` vertices each. The layout's
  /// stride is at most that of the tables' limits; its instance_stride is not 0 where there are
  /// several.
  GpuPatches(Context& context, const PatchTables& tables, const Buffer& given, const Buffer& state,
             const VertexLayout& layout, std::uint64_t vertex_count = 0,
             const Instances& instances = {}, const ListedPatches& listed = {});

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
  Instances instances_;
  VkBuffer work_ = VK_NULL_HANDLE;  // where patches are listed
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
