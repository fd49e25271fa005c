#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planish/vulkan/edit/edit_tables.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/gpu_places.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/fair/fair_tables.h"
#include "planish/vulkan/host/frame_slots.h"
#include "planish/vulkan/host/host_ranges.h"
#include "planish/vulkan/levels/gpu_levels.h"
#include "planish/vulkan/solve/bending_tables.h"
#include "planish/vulkan/solve/gpu_given.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::vulkan {

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
