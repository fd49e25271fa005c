#include "planish/vulkan/host/frame_parts.h"

#include <cstring>
#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/host/system.h"

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
  void write_table(const DeviceTable& table, const StencilView<double>& view) {
    for (std::size_t i = 0; i < table.slices().size(); ++i) {
      const PackedSlice packed = table.pack(i, view);
      write(packed.chunks);
      write(packed.entries);
    }
  }

 private:
  std::byte* place_;
};

void require_editable_system(const System& system, const DeviceSystemOptions& options) {
  if (!options.takes_edits) return;
  if (system.fair_records())
    throw Error(ErrorCode::InvalidArgument,
                "edits are of the progressive method: the polish of the fair one sums over all "
                "points; solve all of them, or make the System with another method");
  if (system.within() > 0)
    throw Error(ErrorCode::InvalidArgument,
                formatted("edits take surfaces through their points, not within {} of them; make "
                          "the System with within 0",
                          std::to_string(system.within())));
}

DeviceTable make_masks(const Maker& on, const System& system) {
  DeviceTableOptions options;
  options.includes_own_rows = true;
  return {on, system.limit_masks(), options};
}

}  // namespace

/// What of a System's surface goes to a device: as large as what the device gets, and kept for
/// write_upload() alone.
struct DeviceSystem::Parts::PackedSurface {
  /// What only some hosts ask for.
  struct Wanted {
    bool places, edits;
  };
  PackedSurface(const System& system, const PatchLimits& limits, const DeviceTable& masks,
                const Wanted& wanted)
      : source(&system.surface_records()) {
    const SurfaceRecords& surface = *source;
    const PatchMesh& mesh = surface.patch_mesh;
    if (surface.sharp_rows) step = step_records(mesh, surface.weights, surface.sharp_rows->view());
    for (const LevelRecords& level : surface.levels.levels) {
      levels.push_back(patch_records(level.patches, limits, false, level.frames));
      levels.back().links.clear();  // which are the other ones'
    }
    patches = patch_records(surface.patches, limits, wanted.edits, surface.frames);
    add_rings(mesh, patches);
    point_count = mesh.point_count();
    if (wanted.places) places = place_records(mesh, surface.weights, limits);
    if (wanted.edits) edits = edit_records(mesh, patches, masks.slots());
  }
  const SurfaceRecords* source;  // by which the System is known
  std::int64_t point_count = 0;
  PatchRecords patches;
  std::optional<StepRecords> step;
  std::optional<PlaceRecords> places;
  std::optional<EditRecords> edits;
  std::vector<PatchRecords> levels;
};

DeviceSystem::Parts::~Parts() = default;

DeviceSystem::Parts::Parts(Context& on, const System& system, const DeviceSystemOptions& options)
    : context(on),
      arena(on),
      max_vertex_stride(options.max_vertex_stride),
      given_count(system.given_count()),
      index_count(static_cast<std::uint32_t>(system.triangles().size())),
      spectral_bound(system.spectral_bound()),
      used_vertices(system.used_vertices().begin(), system.used_vertices().end()),
      masks(make_masks(arena, system)),
      vertex_count(system.vertex_count()),
      vertices(arena, used_vertices.size() * sizeof(std::int32_t), MemoryUse::Device,
               "planish vertices") {
  require_editable_system(system, options);
  packed = std::make_unique<const PackedSurface>(
      system, patch_limits(on, max_vertex_stride), masks,
      PackedSurface::Wanted{options.answers_places, options.takes_edits});
  const PackedSurface& surface = *packed;
  patches.emplace(arena, surface.patches, surface.point_count);
  if (surface.step) step.emplace(arena, *surface.step);
  if (surface.places) places.emplace(arena, *surface.places);
  if (surface.edits) edits.emplace(arena, *surface.edits);
  if (!surface.levels.empty())
    levels.emplace(arena, system.surface_records().levels, surface.levels);
  if (const FairRecords* records = system.fair_records()) fair.emplace(arena, *records);
  if (const BendingRecords* records = system.bending_records()) bending.emplace(arena, *records);
  arena.finish();
  plan_masks();
  for_each(system, [&](const Buffer& buffer, std::span<const std::byte> bytes) {
    copies.push_back({buffer.handle(), bytes.size()});
  });
  for (const Copy& copy : copies) device_bytes += copy.bytes;
  on.log(formatted("planish: a system of {} vertices takes {} bytes, its limit masks in {} slices",
                   used_vertices.size(), device_bytes, masks.slices().size()));
}

void DeviceSystem::Parts::plan_masks() {
  for (const DeviceTable::Slice& slice : masks.slices()) {
    const TableSlice& rows = slice.rows;
    copies.push_back(
        {slice.chunks.handle(), rows.chunk_count * shared::kChunkWords * sizeof(std::uint32_t)});
    copies.push_back({slice.entries.handle(), rows.entry_count * sizeof(PackedEntry)});
  }
}

template <class Take>
void DeviceSystem::Parts::for_each(const System& system, const Take& take) const {
  const PackedSurface& surface = *packed;
  patches->for_each(surface.patches, take);
  if (step) step->for_each(*surface.step, take);
  if (places) places->for_each(*surface.places, take);
  if (edits) edits->for_each(*surface.edits, take);
  if (levels) levels->for_each(system.surface_records().levels, surface.levels, take);
  take(vertices, std::as_bytes(std::span(used_vertices)));
  if (fair) fair->for_each(*system.fair_records(), take);
  if (bending) bending->for_each(*system.bending_records(), take);
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
std::int32_t DeviceSystem::vertex_count() const { return parts_->vertex_count; }
std::vector<std::int32_t> DeviceSystem::level_vertex_counts() const {
  std::vector<std::int32_t> counts;
  if (parts_->levels)
    for (const LevelTables& level : parts_->levels->levels)
      counts.push_back(static_cast<std::int32_t>(level.vertex_count));
  return counts;
}
std::size_t DeviceSystem::slice_count() const {
  return parts_->masks.slices().size() + parts_->patches->slices.size() +
         (parts_->step ? parts_->step->parts.size() : 0);
}
std::uint64_t DeviceSystem::device_bytes() const { return parts_->device_bytes; }

void DeviceSystem::write_upload(const System& system, std::span<std::byte> staging) const {
  if (staging.size() != upload_bytes())
    throw Error(ErrorCode::InvalidArgument,
                formatted("the upload takes {} bytes of staging memory, not {}", upload_bytes(),
                          staging.size()));
  if (!parts_->packed)
    throw Error(ErrorCode::InvalidArgument,
                "the upload was written before, and what it is made of is gone; copy its bytes, or "
                "make another DeviceSystem");
  if (parts_->packed->source != &system.surface_records())
    throw Error(ErrorCode::InvalidArgument, "the upload is not of the System that it was made for");
  StagingWriter writer(staging);
  writer.write_table(parts_->masks, system.limit_masks());
  parts_->for_each(system,
                   [&](const Buffer&, std::span<const std::byte> bytes) { writer.write(bytes); });
  writer.write(system.triangles());
  parts_->packed.reset();
  parts_->masks.finish_packing();
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
