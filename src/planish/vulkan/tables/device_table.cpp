#include "planish/vulkan/tables/device_table.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/vulkan/device/commands.h"
#include "shaders/shared.h"

namespace planish::vulkan {
namespace {

// Based on: M. Kreutzer et al., "A unified sparse matrix data format for efficient general sparse
// matrix-vector multiplication on modern processors with wide SIMD units", 2014 (SELL-C-sigma with
// C = kChunkRows, sigma = kSortWindow).

constexpr std::int32_t kChunkLanes = static_cast<std::int32_t>(shared::kChunkRows);
// Windows start at multiples of 64 points: 1024 bytes, a multiple of every alignment that Vulkan
// allows a device to ask for.
constexpr std::int32_t kWindowAlignment = 64;
static_assert(kWindowAlignment * kPointBytes % 256 == 0);

// A target need not begin where a binding may: what the binding holds before it.
constexpr std::uint64_t kTargetSlack = kWindowAlignment * kPointBytes;

// A slice ends here even where the limits allow more: it bounds what the host holds while it packs.
constexpr std::uint64_t kEnoughEntries = std::uint64_t(32) << 20;

// What the rows of one sort window need.
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

// The slice with the rows of one more window.
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

// Name and value of the limit that the slice exceeds; empty if it fits.
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

// The plan where rows are sorted by size `window_rows` together. Throws as plan_table.
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
PackedSlice pack_slice(const StencilView<Real>& table, const TablePlan& plan,
                       const TableSlice& slice) {
  PackedSlice packed;
  packed.chunks.resize(slice.chunk_count * shared::kChunkWords);
  packed.entries.resize(slice.entry_count);
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
template PackedSlice pack_slice(const StencilView<float>&, const TablePlan&, const TableSlice&);
template PackedSlice pack_slice(const StencilView<double>&, const TablePlan&, const TableSlice&);

template <class Real>
DeviceTable::DeviceTable(const Maker& on, const StencilView<Real>& table,
                         const DeviceTableOptions& options)
    : context_(on.context()), row_count_(table.row_count()), source_count_(table.source_count) {
  const Context& context = context_;
  SliceLimits limits;
  limits.range = context.binding_limit();
  limits.max_chunks = std::uint64_t(context.max_group_count()) * context.variant().chunks_per_group;
  limits.source_stride = options.source_stride;
  limits.target_stride = options.target_stride;
  limits.includes_own_rows = options.includes_own_rows;
  plan_ = plan_table(table, limits);
  slices_.reserve(plan_.slices.size());
  for (const TableSlice& rows : plan_.slices) {
    Slice& slice = slices_.emplace_back();
    slice.rows = rows;
    slice.first_group = group_total_;
    slice.group_count =
        static_cast<std::uint32_t>((rows.chunk_count + context.variant().chunks_per_group - 1) /
                                   context.variant().chunks_per_group);
    group_total_ += slice.group_count;
    slice.entries =
        Buffer(on, rows.entry_count * sizeof(PackedEntry), MemoryUse::Device, "planish entries");
    slice.chunks = Buffer(on, rows.chunk_count * shared::kChunkWords * sizeof(std::uint32_t),
                          MemoryUse::Device, "planish chunks");
  }
}

template <class Real>
PackedSlice DeviceTable::pack(std::size_t i, const StencilView<Real>& table) const {
  return pack_slice(table, plan_, slices_[i].rows);
}

std::vector<std::uint32_t> DeviceTable::slots() const {
  std::vector<std::uint32_t> slots(static_cast<std::size_t>(row_count_));
  for (std::size_t slot = 0; slot < plan_.row_of_slot.size(); ++slot)
    if (plan_.row_of_slot[slot] >= 0)
      slots[plan_.row_of_slot[slot]] = static_cast<std::uint32_t>(slot);
  return slots;
}

std::uint32_t DeviceTable::partials_total() const {
  return group_total_ * (context_.variant().lane_sums ? shared::kChunkRows : 1);
}

shared::TableParameters DeviceTable::parameters(std::size_t i) const noexcept {
  const Slice& slice = slices_[i];
  shared::TableParameters parameters{};
  parameters.chunk_count = static_cast<std::uint32_t>(slice.rows.chunk_count);
  parameters.first_row = static_cast<std::uint32_t>(slice.rows.first_row);
  parameters.first_source = static_cast<std::uint32_t>(slice.rows.first_source);
  parameters.first_group = slice.first_group;
  parameters.partials_total = partials_total();
  return parameters;
}

void DeviceTable::record_dispatch(VkCommandBuffer commands, Kernel kernel, VkDescriptorSet set,
                                  std::size_t i, const shared::TableParameters& parameters,
                                  std::uint32_t instances) const noexcept {
  planish::vulkan::record_dispatch(context_, commands, kernel, set, &parameters,
                                   slices_[i].group_count, instances);
}

template DeviceTable::DeviceTable(const Maker&, const StencilView<float>&,
                                  const DeviceTableOptions&);
template DeviceTable::DeviceTable(const Maker&, const StencilView<double>&,
                                  const DeviceTableOptions&);
template PackedSlice DeviceTable::pack(std::size_t, const StencilView<float>&) const;
template PackedSlice DeviceTable::pack(std::size_t, const StencilView<double>&) const;

BufferRange point_range(const Buffer& points, std::int32_t first, std::int32_t count) {
  // At least one point, for tables without sources: a binding may not be empty.
  return {points.handle(), std::uint64_t(first) * kPointBytes,
          std::uint64_t(std::max(count, 1)) * kPointBytes};
}

namespace {

constexpr std::uint64_t kWindowFloats = kBindingAlignment / sizeof(float);
constexpr std::int32_t kWindowChunks = kSortWindow / static_cast<std::int32_t>(shared::kChunkRows);

Pipeline specialised(const Context& context, std::uint32_t length, std::uint32_t source_stride,
                     std::uint32_t target_stride) {
  const std::uint32_t constants[] = {length, source_stride, target_stride};
  return context.pipelines().specialised(Kernel::ApplyStencils, constants);
}

}  // namespace

ElementWindow element_window(const FloatElements& elements, std::uint64_t first,
                             std::uint64_t count) {
  const std::uint64_t begin = elements.offset + first * elements.stride;
  // At least one element, for tables without sources: a binding may not be empty.
  const std::uint64_t end =
      begin + (std::max<std::uint64_t>(count, 1) - 1) * elements.stride + elements.length;
  ElementWindow window;
  window.shift = static_cast<std::uint32_t>(begin % kWindowFloats);
  window.range = {elements.buffer, (begin - window.shift) * sizeof(float),
                  (end - begin + window.shift) * sizeof(float)};
  return window;
}

std::uint64_t elements_at_once(const Context& context, std::uint64_t stride, std::uint64_t unit) {
  const std::uint64_t floats = context.max_storage_range() / sizeof(float);
  const std::uint64_t fit = floats > kWindowFloats ? (floats - kWindowFloats) / stride : 0;
  const std::uint64_t lanes = std::uint64_t(context.max_group_count()) * shared::kChunkRows;
  return std::max<std::uint64_t>(std::min(fit, lanes) / unit, 1) * unit;
}

void require_window(const Context& context, const ElementWindow& window, const std::string& what,
                    const std::string& remedy) {
  require_binding(context, window.range.size, what, remedy);
}

void StencilPass::compile(const Context& context, std::uint32_t length, std::uint32_t source_stride,
                          std::uint32_t target_stride) {
  static_cast<void>(specialised(context, length, source_stride, target_stride));
}

StencilPass::StencilPass(Context& context, const DeviceTable& table, const FloatElements& source,
                         const FloatElements& target, const PassRows& rows)
    : context_(context),
      pipeline_(specialised(context, source.length, source.stride, target.stride)) {
  PLANISH_ASSERT(source.length == target.length && source.length > 0 && rows.begin >= 0 &&
                 rows.end <= table.row_count());
  // Whole sort windows.
  const auto step =
      static_cast<std::int32_t>(elements_at_once(context, target.stride, kSortWindow));
  const std::uint32_t chunks_per_group = context.variant().chunks_per_group;
  std::vector<BoundKernel> bound;
  for (const DeviceTable::Slice& slice : table.slices()) {
    const TableSlice& part = slice.rows;
    const ElementWindow from = element_window(source, part.first_source, part.source_count);
    for (std::int32_t done = 0; done < part.row_count; done += step) {
      const std::int32_t window_begin = part.first_row + done;
      const std::int32_t window_end = part.first_row + std::min(part.row_count, done + step);
      const std::int32_t begin = std::max(rows.begin, window_begin);
      const std::int32_t end = std::min(rows.end, window_end);
      if (begin >= end) continue;
      const ElementWindow to = element_window(target, begin, end - begin);
      require_window(context, from, "elements that a table's rows read");
      require_window(context, to, "elements that a table's rows write");
      // A sort window's rows lie anywhere in its chunks, but in no others.
      const std::int32_t first_chunk = (begin - part.first_row) / kSortWindow * kWindowChunks;
      const std::int32_t end_chunk =
          std::min((end - part.first_row + kSortWindow - 1) / kSortWindow * kWindowChunks,
                   static_cast<std::int32_t>(part.chunk_count));
      Dispatch& dispatch = dispatches_.emplace_back();
      dispatch.parameters.first_chunk = static_cast<std::uint32_t>(first_chunk);
      dispatch.parameters.chunk_count = static_cast<std::uint32_t>(end_chunk - first_chunk);
      dispatch.parameters.begin_row = static_cast<std::uint32_t>(begin);
      dispatch.parameters.end_row = static_cast<std::uint32_t>(end);
      dispatch.parameters.first_row = static_cast<std::uint32_t>(begin);
      dispatch.parameters.first_source = from.shift;
      dispatch.parameters.first_target = to.shift;
      dispatch.groups = (dispatch.parameters.chunk_count + chunks_per_group - 1) / chunks_per_group;
      bound.push_back({Kernel::ApplyStencils,
                       {whole(slice.entries), whole(slice.chunks), from.range, to.range}});
    }
  }
  sets_ = DescriptorSets(context, bound);
}

void StencilPass::record(VkCommandBuffer commands) const noexcept {
  for (std::size_t i = 0; i < dispatches_.size(); ++i) {
    // Windows of neighbouring dispatches may share their edge.
    if (i > 0) record_barrier(context_, commands, kKernelScope, kKernelScope);
    record_dispatch(context_, commands, pipeline_, sets_[i], &dispatches_[i].parameters,
                    dispatches_[i].groups);
  }
}

}  // namespace planish::vulkan
