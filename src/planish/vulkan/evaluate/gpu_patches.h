#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planish/vulkan/device/rounds.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// What kernels list for dispatches to come, in words of a buffer; see shaders/shared.h. Positions
/// and attributes are then in one buffer.
struct PatchLists {
  const Buffer* work = nullptr;  ///< null: all patches of all instances are done
  /// ListedPatches, or InstancePatches: all patches of listed instances.
  Kernel kernel = Kernel::ListedPatches;
  /// Words of the first slice's arguments and list, and from a slice to the next.
  std::uint32_t first_arguments = 0, arguments_step = 0, first_list = 0, list_step = 0;
  std::uint32_t job_count = 0;    ///< of ListedPatches, from an instance to the next
  Instances places;               ///< of InstancePatches, among the vertices
  const Buffer* links = nullptr;  ///< where they are in other tables
  /// What messages call the vertices, and say of them where a binding cannot span them.
  std::string vertices = "vertices", remedy = "use smaller strides";
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
  GpuPatches(const Maker& on, const PatchTables& tables, const Buffer& given, const Buffer& state,
             const VertexLayout& layout, std::uint64_t vertex_count = 0,
             const Instances& instances = {}, const PatchLists& lists = {});

  /// Only records, within kEntryScope; all that it writes is ready for kernels.
  void record(VkCommandBuffer commands) const noexcept;
  /// The same round by round.
  Wait record_round(VkCommandBuffer commands, std::size_t round) const noexcept;
  [[nodiscard]] std::size_t round_count() const { return dispatches_.size(); }
  /// Of a round, in x.
  [[nodiscard]] std::uint32_t group_count(std::size_t round) const {
    return dispatches_[round].groups;
  }

 private:
  struct Dispatch {
    Pipeline pipeline;
    shared::CornerPatchParameters parameters;
    std::uint32_t groups;
    VkDeviceSize arguments;  // where patches or instances are listed
  };

  Context& context_;
  Instances instances_;
  VkBuffer work_ = VK_NULL_HANDLE;  // likewise
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

}  // namespace planish::vulkan
