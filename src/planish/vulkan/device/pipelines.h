#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "planish/vulkan/device/functions.h"

namespace planish::vulkan {

/// Every kernel, each one a file of that name in shaders/.
enum class Kernel {
  InterpolationStep,
  ReduceRms,
  FinishSolve,
  ApplyStencils,
  ApplyLimit,
  FirstStep,      ///< only specialised
  CornerPatches,  ///< only specialised
  SurfacePlaces,  ///< only specialised
  RingSums,       ///< only specialised
  CgApply,
  CgAdvance,
  CgTurn,
  ReduceSums,
  StopTest,
  GatherPoints,
  InitialResidual,
  TakeUp,
  ControlPoints,
  EvalPatches,  ///< only specialised
  // Edits; only specialised.
  EditBegin,
  EditTake,
  EditResidual,
  EditAdvance,
  EditCommit,
  EditJobs,
  EditPoints,
  EditStale,
  ListedPatches,
  // Levels by need; only specialised.
  ChooseLevels,
  PlaceInstances,
  InstancePatches,
  // Where the mesh bends least; only specialised.
  BendingDirections,
  BendingRows,
  BendingStep,
  // The fair construction; only specialised.
  FairPlace,
  FairFaceNormals,
  FairVertexNormals,
  FairSectorNormals,
  FairOffsets,
  FairShares,
  FairMaskStep,
  FairPolygons,
  FairReversed,
  FairHandles,
  FairSectors,
  FairCurvePoints,
  FairEdgeFolds,
  FairFaceFolds,
  FairRound,
  FairShrink,
  FairDirections,
  FairRows,
  FairDiagonals,
  FairPrecondition,
  FairLines,
  FairGradient,
  FairStepLength,
  FairDescend,
  FairMomentum,
  FairApplyHeights,
  FairMeasure,
  FairState,
  FairCureEdges,
  FairCureFaces,
  FairCureCurves,
  FairCureVertices,
  FairCureAround,
  FairCureSharp,
  FairCureDecide,
  FairFaceHeights,
  FairCurePlanes,
  FairCurePolygons,
  FairCureCreases,
  FairCureCorners,
};
inline constexpr std::size_t kKernelCount = 74;

/// The name of its file, for debuggers.
[[nodiscard]] const char* name_of(Kernel kernel);

/// Bindings of the kernel with the most of them.
inline constexpr std::uint32_t kMaxBindings = 8;

/// What a binding holds. All but Storage are read only, and are uniform texel buffers where the
/// device reads those faster.
enum class Binding { Storage, Entries, Words, Records, Points, Pairs, Floats };

/// How kernels read the arrays that they only read.
enum class ReadPath { Storage, Texel };

/// VK_FORMAT_UNDEFINED for a storage buffer.
[[nodiscard]] VkFormat texel_format(Binding binding, ReadPath path);
[[nodiscard]] VkDescriptorType descriptor_type(Binding binding, ReadPath path);

struct Pipeline {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  std::span<const Binding> bindings;
  std::uint32_t parameter_bytes = 0;  ///< size of its push constants
};

struct PipelineVariant {
  ReadPath read_path = ReadPath::Storage;
  std::uint32_t chunks_per_group = 1;  ///< chunks of kChunkRows rows that a table kernel walks
  bool lane_sums = false;              ///< partial sums per lane instead of per work group
};

/// Specialisation constants below this one follow from the variant.
inline constexpr std::uint32_t kFirstOwnConstant = 3;

/// The compute pipelines of all kernels on one device; those that few hosts want only by
/// specialised().
class Pipelines {
 public:
  /// Throws planish::Error.
  Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
            const VkAllocationCallbacks* callbacks, const PipelineVariant& variant);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  [[nodiscard]] const Pipeline& operator[](Kernel kernel) const {
    return pipelines_[static_cast<std::size_t>(kernel)];
  }

  /// The kernel with its own specialisation constants, those with ids from kFirstOwnConstant on,
  /// instead of their defaults. Compiled when first asked for; as long-lived as this. Thread-safe.
  /// Throws planish::Error.
  [[nodiscard]] Pipeline specialised(Kernel kernel, std::span<const std::uint32_t> constants) const;

 private:
  void create(Kernel kernel);
  [[nodiscard]] VkPipeline compile(Kernel kernel, VkPipelineLayout layout,
                                   std::span<const std::uint32_t> constants) const;
  void destroy() noexcept;

  const DeviceFunctions& vk_;
  VkDevice device_;
  VkPipelineCache cache_;
  const VkAllocationCallbacks* callbacks_;
  PipelineVariant variant_;
  std::array<Pipeline, kKernelCount> pipelines_{};
  mutable std::mutex mutex_;  // of specialised_
  mutable std::map<std::pair<Kernel, std::vector<std::uint32_t>>, VkPipeline> specialised_;
};

}  // namespace planish::vulkan
