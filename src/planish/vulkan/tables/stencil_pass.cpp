#include "planish/vulkan/tables/stencil_pass.h"

#include <algorithm>
#include <string>

#include "planish/core/assert.h"
#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

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
