#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

/// The first step on the device: from given points and their displacement to the state of level 1
/// as GpuPatches reads it. Externally synchronised; tables and points outlive it.
class GpuFirstStep {
 public:
  /// What it reads and writes.
  struct Points {
    const Buffer *given, *displacement;
    std::uint64_t vertex_count;
    const Buffer* state;
  };

  /// `given`, `displacement`: shared::kPointFloats floats for each of `vertex_count` vertices,
  /// instance by instance.
  GpuFirstStep(const Maker& on, const PatchTables& patches, const StepTables& tables,
               const Buffer& given, const Buffer& displacement, std::uint64_t vertex_count = 0,
               const Instances& instances = {});
  /// The listed ones of these instances, into a state that is there.
  GpuFirstStep(const Maker& on, const PatchTables& patches, const StepTables& tables,
               const Points& points, const Instances& instances, const InstanceList& listed);

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

  void bind(const Maker& on, const PatchTables& patches, const StepTables& tables,
            const InstanceList& listed);

  Context& context_;
  Instances instances_;
  std::unique_ptr<Buffer> own_state_;  // where it is not given
  Points points_;
  std::vector<Dispatch> dispatches_;
  DescriptorSets sets_;
};

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
