// Based on: M. Kreutzer et al., "A unified sparse matrix data format for efficient general sparse
// matrix-vector multiplication on modern processors with wide SIMD units", 2014 (SELL-C-sigma with
// C = kChunkRows, sigma = kSortWindow).
#include "planish/vulkan/tables/table_slices.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "shaders/shared.h"

namespace planish::vulkan {

namespace {

constexpr std::int32_t kChunkLanes = static_cast<std::int32_t>(shared::kChunkRows);
// Windows start at multiples of 64 points: 1024 bytes, a multiple of every alignment that Vulkan
// allows a device to ask for.
constexpr std::int32_t kWindowAlignment = 64;
static_assert(kWindowAlignment * kPointBytes % 256 == 0);

// A target need not begin where a binding may: what the binding holds before it.
constexpr std::uint64_t kTargetSlack = kWindowAlignment * kPointBytes;

// A slice ends here even where the limits allow more: it bounds what the host holds while it packs.
constexpr std::uint64_t kEnoughEntries = std::uint64_t(32) << 20;

/// What the rows of one sort window need.
struct WindowNeeds {
  std::uint64_t entries = 0;
  std::int32_t lowest_source = std::numeric_limits<std::int32_t>::max();
  std::int32_t end_source = 0;
};

template <class Real>
WindowNeeds sort_window(const StencilView<Real>& table, std::int32_t first, std::int32_t size,
                        bool own_rows, TablePlan& plan) {
  const std::int32_t last = std::min(first + size, table.row_count());
  const auto slots = plan.row_of_slot.begin() + first;
  std::iota(slots, slots + (last - first), first);
  std::stable_sort(slots, slots + (last - first),
                   [&](std::int32_t a, std::int32_t b) { return table.sizes[a] > table.sizes[b]; });
  WindowNeeds needs;
  for (std::int32_t slot = first; slot < last; slot += kChunkLanes) {
    const std::int32_t width = table.sizes[plan.row_of_slot[slot]];
    plan.chunk_widths[slot / kChunkLanes] = width;
    needs.entries += std::uint64_t(width) * kChunkLanes;
  }
  for (std::int32_t row = first; row < last; ++row) {
    if (own_rows) {
      needs.lowest_source = std::min(needs.lowest_source, row);
      needs.end_source = std::max(needs.end_source, row + 1);
    }
    for (std::int32_t source : table.indices.subspan(table.offsets[row], table.sizes[row])) {
      needs.lowest_source = std::min(needs.lowest_source, source);
      needs.end_source = std::max(needs.end_source, source + 1);
    }
  }
  if (needs.end_source == 0) needs.lowest_source = 0;
  needs.lowest_source -= needs.lowest_source % kWindowAlignment;
  return needs;
}

/// The slice with the rows of one more window.
TableSlice extended(const TableSlice& slice, const WindowNeeds& needs, std::int32_t rows) {
  TableSlice result = slice;
  result.chunk_count += (rows + kChunkLanes - 1) / kChunkLanes;
  result.entry_count += needs.entries;
  const std::int32_t end_source =
      std::max(slice.first_source + slice.source_count, needs.end_source);
  if (slice.row_count == 0) {
    result.first_source = needs.lowest_source;
    result.source_count = needs.end_source - needs.lowest_source;
  } else {
    result.first_source = std::min(slice.first_source, needs.lowest_source);
    result.source_count = end_source - result.first_source;
  }
  result.row_count += rows;
  return result;
}

/// Name and value of the limit that the slice exceeds; empty if it fits.
std::string exceeded(const TableSlice& slice, const SliceLimits& limits) {
  const std::uint64_t bytes = std::max(
      {slice.entry_count * sizeof(PackedEntry),
       slice.chunk_count * shared::kChunkWords * sizeof(std::uint32_t),
       slice.row_count * std::max(limits.target_stride, limits.source_stride) + kTargetSlack,
       slice.source_count * limits.source_stride});
  if (!limits.range.allows(bytes))
    return formatted("{} bytes of one binding, but {} is {}", bytes, limits.range.name,
                     limits.range.bytes);
  if (slice.chunk_count > limits.max_chunks)
    return formatted("{} chunks in one dispatch, but maxComputeWorkGroupCount allows {}",
                     slice.chunk_count, limits.max_chunks);
  return {};
}

/// The plan where rows are sorted by size `window_rows` together. Throws as plan_table.
template <class Real>
TablePlan plan_with_windows(const StencilView<Real>& table, const SliceLimits& limits,
                            std::int32_t window_rows) {
  const std::int32_t rows = table.row_count();
  const std::int32_t window_count = (rows + window_rows - 1) / window_rows;
  const std::size_t chunk_count = (std::size_t(rows) + kChunkLanes - 1) / kChunkLanes;
  TablePlan plan;
  plan.row_of_slot.assign(chunk_count * kChunkLanes, -1);
  plan.chunk_widths.assign(chunk_count, 0);
  std::vector<WindowNeeds> needs(window_count);
  parallel_each(needs.size(), 16, [&](std::int32_t window) {
    needs[window] =
        sort_window(table, window * window_rows, window_rows, limits.includes_own_rows, plan);
  });

  TableSlice slice;
  for (std::int32_t window = 0; window < window_count; ++window) {
    const std::int32_t first_row = window * window_rows;
    const std::int32_t count = std::min(window_rows, rows - first_row);
    TableSlice longer = extended(slice, needs[window], count);
    const bool full = longer.entry_count > kEnoughEntries || !exceeded(longer, limits).empty();
    if (slice.row_count > 0 && full) {
      plan.slices.push_back(slice);
      slice = {};
      slice.first_chunk = std::size_t(first_row) / kChunkLanes;
      slice.first_row = first_row;
      longer = extended(slice, needs[window], count);
    }
    if (const std::string limit = exceeded(longer, limits); !limit.empty())
      throw Error(ErrorCode::OutOfMemory,
                  formatted("rows from {} on need {}; use --device cpu or a smaller mesh",
                            slice.first_row, limit),
                  slice.first_row);
    slice = longer;
  }
  if (slice.row_count > 0) plan.slices.push_back(slice);
  return plan;
}

}  // namespace

template <class Real>
TablePlan plan_table(const StencilView<Real>& table, const SliceLimits& limits) {
  for (std::int32_t window_rows = kSortWindow; window_rows > kChunkLanes; window_rows /= 2) {
    try {
      return plan_with_windows(table, limits, window_rows);
    } catch (const Error&) {
      // Smaller windows may fit.
    }
  }
  return plan_with_windows(table, limits, kChunkLanes);
}

template <class Real>
PackedSlice pack_slice(const StencilView<Real>& table, bool with_derivatives, const TablePlan& plan,
                       const TableSlice& slice) {
  PackedSlice packed;
  packed.chunks.resize(slice.chunk_count * shared::kChunkWords);
  packed.entries.resize(slice.entry_count);
  if (with_derivatives) packed.derivatives.resize(slice.entry_count);
  std::uint32_t first = 0;
  for (std::size_t i = 0; i < slice.chunk_count; ++i) {
    const auto width = static_cast<std::uint32_t>(plan.chunk_widths[slice.first_chunk + i]);
    packed.chunks[i * shared::kChunkWords] = first;
    packed.chunks[i * shared::kChunkWords + 1] = width;
    first += width;
  }
  const auto pack_row = [&](const std::uint32_t* head, std::int32_t lane, std::int32_t row) {
    const std::size_t width = head[1];
    const std::size_t size = row < 0 ? 0 : table.sizes[row];
    const std::size_t from = row < 0 ? 0 : table.offsets[row];
    // Padding repeats the row's first source: with weight 0 it changes no finite sum, and it
    // spreads no other row's infinity.
    const auto spare =
        static_cast<std::uint32_t>(size > 0 ? table.indices[from] - slice.first_source : 0);
    for (std::size_t k = 0; k < width; ++k) {
      const std::size_t to = (head[0] + k) * kChunkLanes + lane;
      packed.entries[to] = {spare, 0.0f};
      if (k >= size) continue;
      packed.entries[to] = {
          static_cast<std::uint32_t>(table.indices[from + k] - slice.first_source),
          static_cast<float>(table.weights[from + k])};
      if (with_derivatives)
        packed.derivatives[to] = {static_cast<float>(table.du_weights[from + k]),
                                  static_cast<float>(table.dv_weights[from + k])};
    }
  };
  parallel_each(slice.chunk_count, 256, [&](std::size_t i) {
    std::uint32_t* head = &packed.chunks[i * shared::kChunkWords];
    for (std::int32_t lane = 0; lane < kChunkLanes; ++lane) {
      const std::int32_t row = plan.row_of_slot[(slice.first_chunk + i) * kChunkLanes + lane];
      head[2 + lane] = static_cast<std::uint32_t>(row);  // -1 is kNoRow
      pack_row(head, lane, row);
    }
  });
  return packed;
}

template TablePlan plan_table(const StencilView<float>&, const SliceLimits&);
template TablePlan plan_table(const StencilView<double>&, const SliceLimits&);
template PackedSlice pack_slice(const StencilView<float>&, bool, const TablePlan&,
                                const TableSlice&);
template PackedSlice pack_slice(const StencilView<double>&, bool, const TablePlan&,
                                const TableSlice&);

}  // namespace planish::vulkan
