#include "planish/vulkan/tables/device_table.h"

#include <algorithm>

#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

template <class Real>
DeviceTable::DeviceTable(const Maker& on, const StencilView<Real>& table,
                         const DeviceTableOptions& options)
    : context_(on.context()),
      row_count_(table.row_count()),
      source_count_(table.source_count),
      has_derivatives_(options.has_derivatives) {
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
    if (has_derivatives_)
      slice.derivatives = Buffer(on, rows.entry_count * sizeof(PackedDerivative), MemoryUse::Device,
                                 "planish derivatives");
  }
}

template <class Real>
PackedSlice DeviceTable::pack(std::size_t i, const StencilView<Real>& table) const {
  return pack_slice(table, has_derivatives_, plan_, slices_[i].rows);
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
  parameters.target_stride = shared::kPointFloats;
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

}  // namespace planish::vulkan
