#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/vulkan/edit/gpu_edit.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/gpu_places.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/fair/gpu_fair.h"
#include "planish/vulkan/levels/gpu_levels.h"
#include "planish/vulkan/solve/gpu_given.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

/// Of a host's point or normal.
inline constexpr std::uint32_t kVectorBytes = 3 * sizeof(float);

/// Throws Error{InvalidArgument} with formatted() text where the condition fails.
template <class... Values>
void require_option(bool condition, FormatText<sizeof...(Values)> format, const Values&... values) {
  if (!condition) throw Error(ErrorCode::InvalidArgument, formatted(format, values...));
}

/// What a Solve has of each instance, in numbers.
struct InstanceSizes {
  std::uint64_t given, rows, points, vertices;  ///< points: of the state of level 1
  std::uint32_t max_vertex_stride;
  bool is_fair;
  bool takes_edits;   ///< the tables for them are there
  bool has_tangents;  ///< likewise
  bool has_surface;   ///< that state is there
};

/// Throws Error{InvalidArgument}.
void check_layout(const VertexLayout& layout, const InstanceSizes& sizes);

/// Every slot, the first one, too, with the strides between instances that 0 stands for. Throws
/// Error{InvalidArgument}, and Error{OutOfMemory} naming the limit that vectors of all instances
/// exceed, before any memory is taken.
[[nodiscard]] std::vector<FrameSlot> checked_slots(const Context& context,
                                                   const InstanceSizes& sizes,
                                                   const SolveOptions& options);

/// Bytes of a host's buffer: of each instance `count` elements, each of which has `bytes` from
/// `offset` on.
struct HostRange {
  std::string what;  ///< as messages call it
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  std::uint64_t stride = 0, count = 0, bytes = 0;
  std::uint64_t instance_stride = 0, instances = 1;
};

/// Throws Error{InvalidArgument} where one that is read has a byte of one that is written.
void require_apart(std::span<const HostRange> read, std::span<const HostRange> written);
/// The same of every two of them, which are written together.
void require_apart(std::span<const HostRange> written);

/// What solves and edits read: points, and lists of what has moved.
[[nodiscard]] std::vector<HostRange> read_ranges(std::span<const FrameSlot> slots,
                                                 const InstanceSizes& sizes,
                                                 std::uint32_t instances);
/// What an evaluation writes of each vertex; `whose` says which vertices.
[[nodiscard]] std::vector<HostRange> vertex_ranges(const VertexLayout& layout,
                                                   const std::string& whose,
                                                   std::uint64_t vertex_count,
                                                   std::uint32_t instances);

/// What a DeviceSystem holds, for the Solves made on it.
struct DeviceSystem::Parts {
  Parts(Context& context, const System& system, const DeviceSystemOptions& options);
  ~Parts();
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  /// Bytes of the staging range that go to the start of a buffer.
  struct Copy {
    VkBuffer target;
    std::uint64_t bytes;
  };
  struct PackedSurface;
  void plan_masks();
  /// Calls take(buffer, bytes) for all that comes after the masks, in the order of copies; while
  /// there is `packed`.
  template <class Take>
  void for_each(const System& system, const Take& take) const;

  Context& context;
  Arena arena;  // of all that follows
  std::uint32_t max_vertex_stride;
  std::int32_t given_count;
  std::uint32_t index_count;
  double spectral_bound;
  std::vector<std::int32_t> used_vertices;
  DeviceTable masks;
  std::int32_t vertex_count;
  std::optional<PatchTables> patches;
  std::optional<BendingTables> bending;         // where points may be moved
  std::optional<StepTables> step;               // where the method is not fair
  std::optional<FairTables> fair;               // where that is the method
  std::optional<PlaceTables> places;            // where they were asked for
  std::optional<EditTables> edits;              // likewise
  std::optional<LevelSetTables> levels;         // where the System has some
  Buffer vertices;                              // used_vertices, on the device
  std::unique_ptr<const PackedSurface> packed;  // until the upload is written
  std::vector<Copy> copies;  // in the order of their bytes; indices come after them
  std::uint64_t device_bytes = 0;
};

/// What a Solve has for a Tessellation. `given` makes the control points of the progressive method.
struct EvaluatedParts {
  InstanceSizes sizes;
  ChosenParts chosen;
  const GpuGiven* given;
  std::span<const HostRange> read;  ///< of the host's buffers
};

/// What a Solve has of an instance's surface, for Places. Both of shared::kPointFloats floats a
/// point, as GpuPatches takes them.
struct SolvePoints {
  BufferRange given;
  BufferRange state;
};

}  // namespace planish::vulkan
