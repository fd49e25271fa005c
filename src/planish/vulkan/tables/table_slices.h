#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "planish/stencil/stencil_table.h"
#include "planish/vulkan/device/binding_limit.h"
#include "shaders/shared.h"

namespace planish::vulkan {

/// A point in a buffer.
inline constexpr std::uint64_t kPointBytes = shared::kPointFloats * sizeof(float);

/// Rows that are sorted by size together, so that rows of one chunk have about the same; slices
/// consist of whole windows. Where the limits are too low for that, windows are smaller.
inline constexpr std::int32_t kSortWindow = 1024;

/// Consecutive rows of a table that one dispatch does, with what its bindings must span.
struct TableSlice {
  std::size_t first_chunk = 0, chunk_count = 0;
  std::uint64_t entry_count = 0;  ///< padding included
  std::int32_t first_row = 0, row_count = 0;
  std::int32_t first_source = 0, source_count = 0;  ///< first_source is a multiple of 64
};

/// Where every row of a table goes; see shaders/shared.h for chunks.
struct TablePlan {
  std::vector<std::int32_t> row_of_slot;   ///< -1 in slots without a row
  std::vector<std::int32_t> chunk_widths;  ///< entries of the longest row, per chunk
  std::vector<TableSlice> slices;
};

struct SliceLimits {
  BindingLimit range;
  std::uint64_t max_chunks = 0;      ///< that one dispatch may walk
  std::uint64_t source_stride = 16;  ///< bytes from one point of the source to the next
  std::uint64_t target_stride = 16;  ///< bytes that a row takes in the target
  bool includes_own_rows = false;    ///< row i also reads source i
};

/// Cuts a table into as few slices as the limits allow. Throws Error{OutOfMemory} naming the limit
/// where the rows of one chunk alone exceed it.
template <class Real>
[[nodiscard]] TablePlan plan_table(const StencilView<Real>& table, const SliceLimits& limits);

struct PackedEntry {
  std::uint32_t source;  ///< counted from the slice's first_source
  float weight;
};
struct PackedDerivative {
  float du, dv;
};

/// A slice as the kernels read it.
struct PackedSlice {
  std::vector<std::uint32_t> chunks;
  std::vector<PackedEntry> entries;
  std::vector<PackedDerivative> derivatives;  ///< as many as entries, or none
};

template <class Real>
[[nodiscard]] PackedSlice pack_slice(const StencilView<Real>& table, bool with_derivatives,
                                     const TablePlan& plan, const TableSlice& slice);

}  // namespace planish::vulkan
