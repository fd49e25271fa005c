#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/patches/patch_surface.h"
#include "planish/vulkan/device/binding_limit.h"
#include "planish/vulkan/evaluate/texture_rows.h"
#include "shaders/shared.h"

namespace planish::vulkan {

/// Indices [first, first + count); none where count is 0.
struct IndexWindow {
  std::int64_t first = 0, count = 0;
  /// The smallest that holds both.
  [[nodiscard]] IndexWindow joined(const IndexWindow& other) const;
};

/// Patches that one dispatch does, with what its bindings of tables and output must span. Windows
/// of tables begin at multiples of 64.
struct PatchSlice {
  std::uint32_t gather = 0;   ///< shared::kGatherCorner, ...
  std::uint32_t samples = 1;  ///< that a lane evaluates at once, chunk_count times
  std::uint32_t chunk_count = 1;
  std::uint32_t first_group = 0, group_count = 0;
  IndexWindow words, weights;
  IndexWindow rows;  ///< of the output
};

struct PatchLimits {
  BindingLimit range;
  std::uint64_t max_groups = 0;   ///< work groups of one dispatch
  std::uint64_t max_units = 0;    ///< groups times chunks in one dispatch
  std::uint64_t row_stride = 24;  ///< bytes from one row of the output to the next, at most
  bool joins_ways = false;        ///< one slice of shared::kGatherAny, where all of it fits
};

/// The surface's patches as kernels take them; see shaders/shared.h.
struct PatchRecords {
  using Link = std::array<std::uint32_t, 2>;
  using Weight = std::array<float, 4>;

  std::vector<Link> links;  ///< per corner: ccw, shared::kNone at boundaries; next
  std::vector<shared::PatchGroup> groups;
  std::vector<std::uint32_t> words;
  std::vector<Weight> weights;  ///< of point, du, dv; a float unused
  std::vector<PatchSlice> slices;
  std::vector<std::uint32_t> rings;  ///< shared::kRingWords each, and what they name
  std::uint32_t ring_count = 0;
  bool has_frames = false;     ///< groups have those of textured rows
  std::int64_t first_sum = 0;  ///< the place behind the state
  /// Per lane of each group the vertex whose faces have all points of its patch, -1 in lanes
  /// without one; empty where they were not asked for.
  std::vector<std::int32_t> owners;
};

/// All but the rings, see add_rings(). Throws Error{OutOfMemory}, naming the limit that the points
/// of level 1 exceed, or one patch alone. `frames`: one a row where tangents can be asked for, else
/// none.
[[nodiscard]] PatchRecords patch_records(const PatchSurface& surface, const PatchLimits& limits,
                                         bool with_owners = false,
                                         std::span<const RowFrame> frames = {});

/// The mesh's large rings, for a device that makes their sums.
void add_rings(const PatchMesh& mesh, PatchRecords& records);

}  // namespace planish::vulkan
