#include <algorithm>
#include <optional>
#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/evaluate/gpu_places.h"
#include "planish/vulkan/host/device_system.h"
#include "planish/vulkan/host/write_timestamps.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kPlaceBytes = shared::kPlaceWords * sizeof(float);

[[noreturn]] void refuse_places(const std::string& message) {
  throw Error(ErrorCode::InvalidArgument, message);
}

void check_list(const PlaceList& list) {
  if (list.count == 0) refuse_places("a list of places has none; give its count");
  if (list.offset % sizeof(float) != 0 || list.stride % sizeof(float) != 0 ||
      list.stride < kPlaceBytes)
    refuse_places(
        formatted("a list of places with offset {} and stride {}: both are multiples of 4 bytes, "
                  "the stride 12 at least",
                  list.offset, list.stride));
}

// Results from each other, and from the list.
void check_apart(const PlacesOptions& options) {
  const PlaceList& list = options.list;
  const PlaceLayout& to = options.results;
  std::vector<HostRange> written;
  const auto add = [&](const char* what, std::uint32_t offset, std::uint64_t bytes) {
    if (offset != kNotWritten)
      written.push_back({what, to.buffer, to.offset + offset, to.stride, list.count, bytes});
  };
  add("positions of places", to.position_offset, kVectorBytes);
  add("normals of places", to.normal_offset, kVectorBytes);
  add("du of places", to.du_offset, kVectorBytes);
  add("dv of places", to.dv_offset, kVectorBytes);
  add("duu of places", to.duu_offset, kVectorBytes);
  add("duv of places", to.duv_offset, kVectorBytes);
  add("dvv of places", to.dvv_offset, kVectorBytes);
  add("states of places", to.state_offset, sizeof(PlaceState));
  require_apart(written);
  const HostRange read{"a list of places", list.buffer, list.offset,
                       list.stride,        list.count,  kPlaceBytes};
  require_apart(std::span(&read, 1), written);
}

void check_results(const PlacesOptions& options) {
  const PlaceLayout& layout = options.results;
  const std::uint32_t offsets[] = {layout.position_offset, layout.normal_offset, layout.du_offset,
                                   layout.dv_offset,       layout.duu_offset,    layout.duv_offset,
                                   layout.dvv_offset,      layout.state_offset};
  if (!layout.buffer) refuse_places("results of places have no buffer");
  if (layout.offset % sizeof(float) != 0 || layout.stride % sizeof(float) != 0)
    refuse_places(
        formatted("results of places lie at multiples of 4 bytes, not from {} on every {}",
                  layout.offset, layout.stride));
  for (const std::uint32_t offset : offsets)
    if (offset != kNotWritten && (offset % sizeof(float) != 0 || offset >= layout.stride))
      refuse_places(
          formatted("the offset {} of a place's result is no multiple of 4 below the stride {}",
                    offset, layout.stride));
  const std::uint64_t end = result_bytes(layout);
  if (end == 0) refuse_places("no result of places is wanted; give one an offset");
  if (end > layout.stride)
    refuse_places(
        formatted("a place's results end at {} bytes, behind the stride {}", end, layout.stride));
  check_apart(options);
}

const PlaceTables& tables_of(const std::optional<PlaceTables>& tables) {
  if (!tables)
    refuse_places("the DeviceSystem has no tables for places; make it with answers_places");
  return *tables;
}

void check_instance(const Solve& solve, std::uint32_t instance) {
  if (instance >= solve.instance_count())
    refuse_places(formatted("instance {} of places is none of the Solve's {}", instance,
                            solve.instance_count()));
}

std::optional<Buffer> make_list(Context& context, const PlaceList& list) {
  check_list(list);
  if (list.buffer) return {};
  if (list.stride != kPlaceBytes || list.offset != 0)
    refuse_places("a list of places without a buffer begins at 0 with stride 12");
  return Buffer(context, std::uint64_t(list.count) * kPlaceBytes, MemoryUse::Device,
                "planish places");
}

}  // namespace

struct Places::Parts {
  Parts(Context& on, const PatchTables& patches, const PlaceTables& tables,
        const SolvePoints& points, const PlacesOptions& options)
      : context(on), count(options.list.count), own_list(make_list(on, options.list)) {
    check_results(options);
    PlaceList list = options.list;
    if (own_list) list.buffer = own_list->handle();
    places.emplace(on, patches, tables, points.given, points.state, list, options.results);
  }

  Context& context;
  std::uint32_t count;
  std::optional<Buffer> own_list;  // where the host gives no buffer
  std::optional<GpuPlaces> places;
};

SurfaceBuffers surface_buffers(const DeviceSystem& system, const Solve& solve,
                               std::uint32_t instance) {
  const PlaceTables& tables = tables_of(system.parts_->places);
  check_instance(solve, instance);
  const SolvePoints points = solve.surface_points(instance);
  const auto info = [](const BufferRange& range) {
    return VkDescriptorBufferInfo{range.buffer, range.offset, range.size};
  };
  return {info(whole(tables.words)),   info(whole(system.parts_->patches->links)),
          info(points.state),          info(points.given),
          info(whole(tables.weights)), tables.face_count,
          tables.corner_count};
}

Places::Places(Context& context, const DeviceSystem& system, const Solve& solve,
               const PlacesOptions& options) {
  const PlaceTables& tables = tables_of(system.parts_->places);
  check_instance(solve, options.instance);
  parts_ = std::make_unique<Parts>(context, *system.parts_->patches, tables,
                                   solve.surface_points(options.instance), options);
}
Places::~Places() = default;
Places::Places(Places&&) noexcept = default;
Places& Places::operator=(Places&&) noexcept = default;

void Places::record_list(VkCommandBuffer commands, VkBuffer source,
                         VkDeviceSize offset) const noexcept {
  if (!parts_->own_list)
    return parts_->context.tell(
        "planish: record_list does nothing, as the list has a buffer; write that, or set PlaceList "
        "without one");
  const Context& context = parts_->context;
  record_barrier(context, commands, kExitScope, kEntryScope);
  const VkBufferCopy copy{offset, 0, std::uint64_t(parts_->count) * kPlaceBytes};
  context.vk().vkCmdCopyBuffer(commands, source, parts_->own_list->handle(), 1, &copy);
}

void Places::record_evaluate(VkCommandBuffer commands, std::uint32_t count,
                             const Timestamps& timestamps) const noexcept {
  const Context& context = parts_->context;
  const LabelScope label(context, commands, "planish places");
  record_barrier(context, commands, kExitScope, kEntryScope);
  write_first(context, commands, timestamps);
  parts_->places->record(commands, std::min(count, parts_->count));
  write_second(context, commands, timestamps);
}

}  // namespace planish::vulkan
