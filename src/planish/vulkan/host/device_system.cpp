#include "planish/vulkan/host/device_system.h"

#include <cstring>
#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/commands.h"

namespace planish::vulkan {

namespace {

/// Writes one thing after another.
class StagingWriter {
 public:
  explicit StagingWriter(std::span<std::byte> staging) : place_(staging.data()) {}
  template <class Items>
  void write(const Items& items) {
    const auto bytes = std::as_bytes(std::span(items));
    if (!bytes.empty()) std::memcpy(place_, bytes.data(), bytes.size());
    place_ += bytes.size();
  }
  void write_table(const DeviceTable& table, const StencilView<double>& view,
                   const LimitStencilView<double>* derivatives) {
    for (std::size_t i = 0; i < table.slices().size(); ++i) {
      const PackedSlice packed = table.pack(i, view, derivatives);
      write(packed.chunks);
      write(packed.entries);
      write(packed.derivatives);
    }
  }

 private:
  std::byte* place_;
};

DeviceTable make_masks(Context& context, const System& system) {
  DeviceTableOptions options;
  options.includes_own_rows = true;
  return {context, system.limit_masks(), nullptr, options};
}

std::vector<DeviceTable> make_refinement(Context& context, const System& system) {
  std::vector<DeviceTable> tables;
  tables.reserve(system.refinement_count());
  for (std::size_t i = 0; i < system.refinement_count(); ++i)
    tables.emplace_back(context, system.refinement(i), nullptr, DeviceTableOptions{});
  return tables;
}

DeviceTable make_limit(Context& context, const System& system, std::uint32_t vertex_stride) {
  DeviceTableOptions options;
  options.target_stride = vertex_stride;
  const LimitStencilView<double> view = system.limit_stencils();
  return {context, view, &view, options};
}

}  // namespace

DeviceSystem::Parts::Parts(Context& on, const System& system, const DeviceSystemOptions& options)
    : context(on),
      max_vertex_stride(options.max_vertex_stride),
      given_count(system.given_count()),
      index_count(static_cast<std::uint32_t>(system.triangles().size())),
      spectral_bound(system.spectral_bound()),
      used_vertices(system.used_vertices().begin(), system.used_vertices().end()),
      masks(make_masks(on, system)),
      refinement(make_refinement(on, system)),
      limit(make_limit(on, system, options.max_vertex_stride)),
      vertices(on, used_vertices.size() * sizeof(std::int32_t), MemoryUse::Device,
               "planish vertices") {
  plan_copies(masks, false);
  for (const DeviceTable& table : refinement) plan_copies(table, false);
  plan_copies(limit, true);
  copies.push_back({vertices.handle(), used_vertices.size() * sizeof(std::int32_t)});
  if (const FairRecords* records = system.fair_records()) {
    fair.emplace(on, *records);
    fair->for_each(*records, [&](const Buffer& buffer, std::span<const std::byte> bytes) {
      copies.push_back({buffer.handle(), bytes.size()});
    });
  }
  for (const Copy& copy : copies) device_bytes += copy.bytes;
  on.log("planish: a system of " + std::to_string(used_vertices.size()) + " vertices takes " +
         std::to_string(device_bytes) + " bytes, its limit masks in " +
         std::to_string(masks.slices().size()) + " slices");
}

void DeviceSystem::Parts::plan_copies(const DeviceTable& table, bool has_derivatives) {
  for (const DeviceTable::Slice& slice : table.slices()) {
    const TableSlice& rows = slice.rows;
    copies.push_back(
        {slice.chunks.handle(), rows.chunk_count * shared::kChunkWords * sizeof(std::uint32_t)});
    copies.push_back({slice.entries.handle(), rows.entry_count * sizeof(PackedEntry)});
    if (has_derivatives)
      copies.push_back({slice.derivatives.handle(), rows.entry_count * sizeof(PackedDerivative)});
  }
}

DeviceSystem::DeviceSystem(Context& context, const System& system,
                           const DeviceSystemOptions& options)
    : parts_(std::make_unique<Parts>(context, system, options)) {}
DeviceSystem::~DeviceSystem() = default;
DeviceSystem::DeviceSystem(DeviceSystem&&) noexcept = default;
DeviceSystem& DeviceSystem::operator=(DeviceSystem&&) noexcept = default;

std::uint64_t DeviceSystem::upload_bytes() const {
  return parts_->device_bytes + std::uint64_t(parts_->index_count) * sizeof(std::uint32_t);
}
std::uint32_t DeviceSystem::index_count() const { return parts_->index_count; }
std::int32_t DeviceSystem::given_count() const { return parts_->given_count; }
std::int32_t DeviceSystem::vertex_count() const { return parts_->limit.row_count(); }
std::size_t DeviceSystem::slice_count() const {
  std::size_t count = parts_->masks.slices().size() + parts_->limit.slices().size();
  for (const DeviceTable& table : parts_->refinement) count += table.slices().size();
  return count;
}
std::uint64_t DeviceSystem::device_bytes() const { return parts_->device_bytes; }

void DeviceSystem::write_upload(const System& system, std::span<std::byte> staging) const {
  if (staging.size() != upload_bytes())
    throw Error(ErrorCode::InvalidArgument, "the upload takes " + std::to_string(upload_bytes()) +
                                                " bytes of staging memory, not " +
                                                std::to_string(staging.size()));
  if (system.vertex_count() != vertex_count() || system.triangles().size() != index_count() ||
      system.refinement_count() != parts_->refinement.size() ||
      parts_->fair.has_value() != (system.fair_records() != nullptr))
    throw Error(ErrorCode::InvalidArgument, "the upload is not of the System that it was made for");
  StagingWriter writer(staging);
  writer.write_table(parts_->masks, system.limit_masks(), nullptr);
  for (std::size_t i = 0; i < system.refinement_count(); ++i)
    writer.write_table(parts_->refinement[i], system.refinement(i), nullptr);
  const LimitStencilView<double> limit = system.limit_stencils();
  writer.write_table(parts_->limit, limit, &limit);
  writer.write(parts_->used_vertices);
  if (parts_->fair)
    parts_->fair->for_each(
        *system.fair_records(),
        [&](const Buffer&, std::span<const std::byte> bytes) { writer.write(bytes); });
  writer.write(system.triangles());
}

void DeviceSystem::record_upload(VkCommandBuffer commands, VkBuffer staging, VkDeviceSize offset,
                                 const IndexTarget& indices) const noexcept {
  const Context& context = parts_->context;
  const LabelScope label(context, commands, "planish upload");
  record_barrier(context, commands, kExitScope, kEntryScope);
  const auto copy = [&](VkBuffer target, VkDeviceSize target_offset, std::uint64_t bytes) {
    const VkBufferCopy region{offset, target_offset, bytes};
    if (bytes) context.vk().vkCmdCopyBuffer(commands, staging, target, 1, &region);
    offset += bytes;
  };
  for (const Parts::Copy& part : parts_->copies) copy(part.target, 0, part.bytes);
  if (indices.buffer)
    copy(indices.buffer, indices.offset, std::uint64_t(index_count()) * sizeof(std::uint32_t));
}

}  // namespace planish::vulkan
